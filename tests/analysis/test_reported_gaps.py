"""Reports give gaps from bumper to bumper where the scenario does, and say so."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.container import ErrorbarContainer

from tests.conftest import zenvoy
from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.overview import overview_section
from zenvoy.analysis.compare.comparison import Compared, comparison_page
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.analysis.page.section import Picture, Section, Sheet

LENGTH_M: Final = 4.0
SCENARIO: Final = """
duration_s: 14
road: {type: open}
fleet: {size: 4, length_m: 4, bumper_gap_m: 16, speed_mps: 20 REPORTED}
control:
  model: PBCM
  desired_bumper_gap_m: 16
  desired_speed_mps: 20
  schedule:
    - {at_s: 6, vehicles: 3, desired_bumper_gap_m: 20, ramp_s: 2}
sensors: {error: 0.02}
events: [{vehicle: 1, at_s: 2, duration_s: 1, deceleration_mps2: 3}]
"""
WORDS: Final = "bumper to bumper"


@pytest.fixture(scope="module")
def runs(folder: Path) -> tuple[Run, Run]:
    """Return a run with gaps from bumper to bumper, and the same one with gaps between fronts."""
    front = SCENARIO.replace("REPORTED", ", reported_gaps: front-to-front")
    return (
        load(write_log(folder / "bumper.mcap", SCENARIO.replace("REPORTED", ""))),
        load(write_log(folder / "front.mcap", front)),
    )


def sections(run: Run) -> tuple[Section, ...]:
    return (overview_section(run, summary_of(run)), *chapters(run))


def sheets(run: Run) -> dict[str, Sheet]:
    return {sheet.name: sheet for section in sections(run) for sheet in section.sheets}


def pictures(run: Run) -> dict[str, Picture]:
    return {one.name: one for section in sections(run) for one in section.pictures}


def test_the_log_is_the_same(runs: tuple[Run, Run]) -> None:
    bumper, front = runs
    assert bumper.fingerprint == front.fingerprint is not None
    summaries = [summary_of(run) for run in runs]
    assert summaries[0]["smallest_gap_m"] == summaries[1]["smallest_gap_m"]
    shown = summaries[0]["smallest_bumper_gap_m"]
    assert shown == summaries[0]["smallest_gap_m"] - LENGTH_M
    assert summaries[1]["smallest_bumper_gap_m"] is None


def test_tables_have_gaps_less_a_length_and_say_so(runs: tuple[Run, Run]) -> None:
    """Every other number of a report is the same."""
    bumper, front = map(sheets, runs)
    assert bumper.keys() == front.keys()
    said = 0
    for name, sheet in bumper.items():
        for row, other in zip(sheet.rows, front[name].rows, strict=True):
            for k, (cell, plain) in enumerate(zip(row, other, strict=True)):
                by_row = [part for part in row if isinstance(part, str) and WORDS in part]
                in_title = WORDS in sheet.columns[k]
                if isinstance(cell, str):
                    assert cell == plain or WORDS in cell, (name, cell)
                elif in_title or (by_row and isinstance(cell, float) and is_gap(sheet, k)):
                    assert isinstance(plain, float)
                    assert cell == pytest.approx(plain - LENGTH_M), (name, row)
                    said += 1
                else:
                    assert cell == plain, (name, row)
    assert said > 15


def is_gap(sheet: Sheet, column: int) -> bool:
    """Return whether a number is a gap where its row names one; times of manoeuvres are not."""
    return "s" not in sheet.columns[column].split(", ")


def test_reports_between_fronts_say_nothing_new(runs: tuple[Run, Run]) -> None:
    for section in sections(runs[1]):
        for sheet in section.sheets:
            texts = [*sheet.columns, *(cell for row in sheet.rows for cell in row)]
            assert not [text for text in texts if isinstance(text, str) and "to bumper" in text]
    assert sheets(runs[1])["summary"].rows[0][0] == "smallest gap"
    assert "front to front" not in sheets(runs[1])["motion-figures"].note


def test_the_timeline_and_the_notes_say_how_gaps_are_measured(runs: tuple[Run, Run]) -> None:
    timeline = [str(row[2]) for row in sheets(runs[0])["timeline"].rows]
    assert "new targets of vehicle 3: desired gap 20 m bumper to bumper" in timeline
    notes = " ".join(note for section in sections(runs[0]) for note in section.notes)
    assert "because of the change to desired front-to-front gap 24 m within 2 s" in notes
    plain = [str(row[2]) for row in sheets(runs[1])["timeline"].rows]
    assert "new targets of vehicle 3: desired gap 24 m" in plain


def test_pictures_draw_gaps_less_a_length_and_say_so(runs: tuple[Run, Run]) -> None:
    bumper, front = map(pictures, runs)
    assert bumper.keys() == front.keys()
    said = []
    for name, picture in bumper.items():
        panels = [one.draw().axes for one in (picture, front[name])]
        pairs = zip(*panels, strict=True)
        labels = [WORDS in axes.get_ylabel() for axes in panels[0]]
        for (axes, plain), labelled in zip(pairs, with_row(panels[0], labels), strict=True):
            less_m = LENGTH_M if labelled else 0.0
            for own, other in zip(heights(axes), heights(plain), strict=True):
                np.testing.assert_allclose(own, other - less_m, atol=1e-6, err_msg=name)
        said += [name] * any(labels)
    assert said == ["overview", "motion-gaps", "manoeuvres", "estimation-truth"]


def with_row(axes: list[Axes], labels: list[bool]) -> Iterator[bool]:
    """Yield for each panel whether it, or the panel at whose left it shares an axis, says it."""
    for one, labelled in zip(axes, labels, strict=True):
        shared = one.get_shared_y_axes().get_siblings(one)
        yield labelled or any(labels[axes.index(other)] for other in shared)


def heights(axes: Axes) -> list[Any]:
    """Return the heights of all that is drawn from data in a panel; spans and marks are no data."""
    drawn = [np.asarray(line.get_ydata(), float) for line in axes.lines]
    found = [values for values in drawn if values.size > 2]
    for container in axes.containers:
        if isinstance(container, ErrorbarContainer) and container.has_yerr:
            for bars in container.lines[2]:
                found += [segment[:, 1] for segment in bars.get_segments() if len(segment)]
    found += [
        np.asarray(points.get_offsets(), float)[:, 1]
        for points in axes.collections
        if isinstance(points, PathCollection)
    ]
    return found


def compared(*named: tuple[str, Run]) -> list[Compared]:
    return [Compared(label=label, run=run, summary=summary_of(run)) for label, run in named]


def figures(page: Any) -> dict[str, Any]:
    (sheet,) = [
        one for section in page.sections for one in section.sheets if one.name == "compare-figures"
    ]
    return {row[0]: row[2:] for row in sheet.rows}


def test_a_comparison_has_the_gaps_that_its_runs_share(runs: tuple[Run, Run]) -> None:
    bumper, front = runs
    smallest_m = summary_of(front)["smallest_gap_m"]
    page = comparison_page(compared(("a", bumper), ("b", bumper)))
    shown = smallest_m - LENGTH_M
    assert figures(page)["smallest gap, bumper to bumper"] == pytest.approx((shown, shown, 0.0))
    drawn = page.sections[1].pictures[1]
    assert drawn.name == "compare-distances"
    assert WORDS in drawn.caption
    axes = drawn.draw().axes
    assert [one.get_ylabel() for one in axes] == [
        "MaxDistance, bumper to bumper, m",
        "MinDistance, bumper to bumper, m",
    ]
    page = comparison_page(compared(("a", front), ("b", front)))
    assert figures(page)["smallest gap"] == (smallest_m, smallest_m, 0.0)
    plain = page.sections[1].pictures[1].draw().axes
    assert [one.get_ylabel() for one in plain] == ["MaxDistance, m", "MinDistance, m"]
    for own, other in zip(axes, plain, strict=True):
        for one, another in zip(heights(own), heights(other), strict=True):
            np.testing.assert_allclose(one, another - LENGTH_M)


def test_a_comparison_of_both_kinds_has_fronts_and_says_so(runs: tuple[Run, Run]) -> None:
    page = comparison_page(compared(("a", runs[0]), ("b", runs[1])))
    smallest_m = summary_of(runs[1])["smallest_gap_m"]
    assert figures(page)["smallest gap, front to front"] == (smallest_m, smallest_m, 0.0)
    assert (
        "The runs differ in their gaps: a bumper to bumper, b front to front. All gaps are shown "
        "front to front."
    ) in page.notes


def test_the_summary_on_a_terminal_says_how_gaps_are_measured(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO.replace("REPORTED", ""))
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--engine", "in-process", "--out", "o")
    assert outcome.code == 0, outcome
    summary = summary_of(load(tmp_path / "o" / "run.mcap"))
    lines = [line for line in outcome.out.splitlines() if "gap" in line]
    cells = [[cell.strip() for cell in line.split("│")[1:3]] for line in lines]
    assert cells[0] == ["gaps", "bumper to bumper"]
    assert cells[1] == ["smallest gap", f"{summary['smallest_gap_m'] - LENGTH_M:.2f} m"]
    analyzed = zenvoy(tmp_path, "analyze", "o/run.mcap")
    assert "gaps" in analyzed.out
    assert "smallest gap, bumper to bumper" in analyzed.out
