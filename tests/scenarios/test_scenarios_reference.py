"""docs/scenarios.md and the JSON Schema are those of the code, and the page's examples load."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import pytest

from tests import recordings
from tests.scenario_reference import PAGE, SCHEMA, page, rows, schema_file
from zenvoy.scenarios import load

BLOCKS: Final = re.findall(r"```(yaml|csv)\n(.*?)```", PAGE.read_text(), re.DOTALL)


def test_the_page_and_the_schema_are_what_make_docs_writes() -> None:
    assert PAGE.read_text(encoding="utf-8") == page()
    assert SCHEMA.read_text(encoding="utf-8") == schema_file()


def test_every_key_says_what_it_means() -> None:
    silent = [(row.section, row.key) for row in rows() if not row.meaning and row.key != "type"]
    assert silent == []
    assert len(rows()) > 250


@pytest.mark.parametrize("text", [text for kind, text in BLOCKS if kind == "yaml"])
def test_the_examples_load(tmp_path: Path, text: str) -> None:
    (tmp_path / "s.yaml").write_text(text)
    (tmp_path / "drive.csv").write_text(next(text for kind, text in BLOCKS if kind == "csv"))
    (tmp_path / "openacc.csv").write_text(recordings.OPENACC)
    (tmp_path / "fcd.csv").write_text(recordings.FCD)
    (tmp_path / "epa.txt").write_text(recordings.EPA)
    load(tmp_path / "s.yaml")
