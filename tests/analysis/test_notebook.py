"""docs/notebook.md shows the actual output of its code."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest

from tests.conftest import zenvoy

DOCUMENT = Path(__file__).parents[2] / "docs" / "notebook.md"


def test_the_examples_give_the_shown_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = zenvoy(tmp_path, "run", "quickstart", "--out", "runs/q", "--bus", "in-process")
    assert outcome.code == 0, outcome.err
    monkeypatch.chdir(tmp_path)
    found = doctest.testfile(str(DOCUMENT), module_relative=False, encoding="utf-8")
    assert found.attempted > 20
    assert found.failed == 0
