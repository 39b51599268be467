"""Helpers make the chapter "String stability" of small runs."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.stability import stability_section
from zenvoy.analysis.page.section import Section, Sheet
from zenvoy.analysis.page.style import look

QUIET = "sensors: {error: 0}\n"
BRAKE = "events: [{type: brake, vehicle: 2, at_s: 2, duration_s: 1, deceleration_mps2: 1}]\n"


def chapter(folder: Path, scenario: str) -> Section:
    """Return the chapter of a run, and check that rows fit and that pictures can be drawn."""
    section = stability_section(load(write_log(folder / "run.mcap", scenario)))
    assert section.title == "String stability"
    for sheet in section.sheets:
        assert sheet.rows
        assert {len(row) for row in sheet.rows} == {len(sheet.columns)}
    with look():
        for picture in section.pictures:
            file = BytesIO()
            picture.draw().savefig(file, format="png", dpi=50)
            assert file.tell() > 2_000
    return section


def sheet(section: Section, name: str) -> Sheet:
    return next(found for found in section.sheets if found.name == name)


def pictures(section: Section) -> set[str]:
    return {picture.name for picture in section.pictures}
