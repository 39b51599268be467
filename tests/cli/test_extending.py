"""The files and commands of docs/extending.md work as they are on the page."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Final

from tests.conftest import zenvoy
from tests.docs_blocks import named_blocks
from zenvoy.analysis.log.load import load

PAGE: Final = Path(__file__).parents[2] / "docs" / "extending.md"


def test_the_page_leads_from_an_empty_folder_to_a_comparison(tmp_path: Path) -> None:
    commands = []
    for language, name, body in named_blocks(PAGE.read_text("utf-8")):
        if language == "sh":
            commands += body.splitlines()
        else:
            (tmp_path / name).write_text(body)
    assert len(commands) == 7
    for line in commands:
        program, *arguments = shlex.split(line)
        assert program == "zenvoy"
        outcome = zenvoy(tmp_path, *arguments)
        assert (outcome.code, outcome.err) == (0, ""), line
    run = load(tmp_path / "fvdm" / "run.mcap")
    assert run.estimate["FVDM.wanted_speed"].shape == (600, 8)
    assert run.units["/fleet/estimate"]["FVDM.wanted_speed"] == "m/s"
    report = (tmp_path / "fvdm" / "run-analysis" / "report.html").read_text()
    assert "fvdm:FVDM" in report
    assert "FVDM.wanted_speed" in (tmp_path / "fvdm" / "csv" / "estimate.csv").read_text()
    assert (tmp_path / "comparison" / "compare-speeds.png").exists()
