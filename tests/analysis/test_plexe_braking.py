"""The report of a braking, as in Plexe's examples, agrees with the true motion in the log."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from tests.logs import write_log
from tests.pages import read
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.page.html import Page, render
from zenvoy.analysis.page.section import Section, Sheet

CASE: Final = Path(__file__).parents[1] / "cases" / "plexe-braking.yaml"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return load(write_log(tmp_path_factory.mktemp("plexe") / "run.mcap", CASE.read_text()))


@pytest.fixture(scope="module")
def sections(run: Run) -> tuple[Section, ...]:
    return chapters(run)


def sheet(sections: tuple[Section, ...], name: str) -> Sheet:
    return next(sheet for section in sections for sheet in section.sheets if sheet.name == name)


def test_every_dip_is_at_the_lowest_true_speed(run: Run, sections: tuple[Section, ...]) -> None:
    """Vehicles 4 and 5 are slowest in the same cycle, and 8 after a long, flat dip."""
    lowest_s = run.time_s[run.truth["speed"].argmin(axis=0)]
    assert lowest_s.round(1).tolist() == [15.0, 15.2, 15.3, 15.5, 15.5, 15.7, 15.9, 16.9]
    vehicles = sheet(sections, "stability-vehicles")
    column = vehicles.columns.index("dip at, s")
    found = [row[column] for row in vehicles.rows]
    assert found == pytest.approx(lowest_s.tolist(), abs=0.051)  # half a cycle
    assert found[0] == 15.0  # the end of the braking, to the row


def test_the_direction_of_the_dip_is_described_in_words(sections: tuple[Section, ...]) -> None:
    rows = {row[0]: row for row in sheet(sections, "stability-figures").rows}
    against = rows["dip backwards, speed over the road, against the traffic"]
    assert isinstance(against[2], float)
    assert against[2] > 0.0
    for row in rows.values():
        if row[1] in {"m/s", "vehicles/s"}:
            assert all(cell is None or float(cell) >= 0.0 for cell in row[2:]), row


def test_no_row_or_column_of_the_page_has_only_dashes(
    sections: tuple[Section, ...],
) -> None:
    bare = tuple(Section(title=section.title, sheets=section.sheets) for section in sections)
    page = render(Page(title="x", sections=bare), {})
    read(page)
    assert (
        "theory"
        not in page.partition("Vehicles that the disturbance reaches")[2].split("</table>")[0]
    )
    shown = [sheet.without_empty() for section in bare for sheet in section.sheets]
    for table in filter(None, shown):
        names = table.columns.index("unit") + 1 if "unit" in table.columns else 1
        for row in table.rows:
            assert any(cell is not None for cell in row[names:]), (table.name, row)
        for k, title in enumerate(table.columns):
            assert any(row[k] is not None for row in table.rows), (table.name, title)
