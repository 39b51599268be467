"""Every picture of every report has a legend, names, and marks of what happened."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.analysis.test_evidence import evidence
from tests.logs import write_log
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.overview import overview_section
from zenvoy.analysis.compare.pictures import Labelled, comparison_pictures
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.analysis.page.section import Picture, Section
from zenvoy.analysis.page.style import look
from zenvoy.analysis.paper.reproduction import pictures as paper_pictures

RING: Final = """
duration_s: 30
fleet: {size: 8}
sensors: {error: 0.03}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}]}
channel:
  loss: {p: 0.1}
  medium: {access: csma}
  outages: [{from_s: 12, until_s: 14}]
events: [{vehicle: 2, at_s: 8, duration_s: 2, deceleration_mps2: 3}]
"""
OPEN: Final = """
duration_s: 30
road: {type: open}
fleet: {size: 4}
control: {model: CACC}
channel: {outages: [{from_s: 12, until_s: 14}], latency: {distribution: pareto, min_ms: 1,
  mean_ms: 20}}
events: [{vehicle: 1, at_s: 8, duration_s: 2, deceleration_mps2: 3}]
"""
STEADY: Final = "{duration_s: 5, fleet: {size: 3}, sensors: {error: 0.03}}"


def sections_of(run: Run) -> tuple[Section, ...]:
    return (overview_section(run, summary_of(run)), *chapters(run))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Labelled]:
    folder = tmp_path_factory.mktemp("pictures")
    texts = {"ring": RING, "open": OPEN, "steady": STEADY}
    return [
        Labelled(name, load(write_log(folder / f"{name}.mcap", text)))
        for name, text in texts.items()
    ]


def of_one(runs: list[Labelled]) -> Iterator[tuple[str, Picture]]:
    for label, run in runs:
        for section in sections_of(run):
            yield from ((label, picture) for picture in section.pictures)


def drawn_as_saved(picture: Picture) -> Figure:
    with look():
        figure = picture.draw()
        FigureCanvasAgg(figure)
        figure.draw_without_rendering()
    return figure


def covered(figure: Figure) -> list[Any]:
    """Return the axes on which a legend covers something."""
    canvas: Any = figure.canvas  # the one that the picture sets
    renderer = canvas.get_renderer()
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes)]
    boxes = [legend.get_window_extent(renderer) for legend in legends if legend is not None]
    return [
        axes
        for axes in figure.axes
        if axes.get_visible()
        for box in boxes
        if box.shrunk(0.99, 0.9).overlaps(axes.get_window_extent(renderer))
    ]


def test_no_legend_covers_data(runs: list[Labelled]) -> None:
    pictures = [*of_one(runs), *(("all", picture) for picture in comparison_pictures(runs))]
    assert len(pictures) > 30
    for label, picture in pictures:
        assert not covered(drawn_as_saved(picture)), f"{label}: {picture.name}"


def test_no_legend_of_the_papers_figures_covers_data() -> None:
    found = paper_pictures(evidence())
    assert len(found) == 6
    for picture in found:
        figure = drawn_as_saved(picture)
        assert figure.legends or picture.name == "heat-maps"
        assert not covered(figure), picture.name


def test_every_axis_of_time_shows_an_outage(runs: list[Labelled]) -> None:
    seen = set()
    both = [pair for pair in of_one(runs) if pair[0] != "steady"]
    for label, picture in [*both, *(("", p) for p in comparison_pictures(runs[:2]))]:
        figure = drawn_as_saved(picture)
        on_time = [axes for axes in figure.axes if _is_of_time(figure, axes)]
        for axes in on_time:
            shown = set(axes.get_legend_handles_labels()[1])
            assert {"brake", "outage"} <= shown, f"{label}: {picture.name}"
        seen |= {picture.name} if on_time else set()
    assert seen >= {
        "overview",
        "motion-space-time",
        "motion-heat-map",
        "motion-gaps",
        "motion-time-to-collision",
        "stability-modes",
        "estimation-truth",
        "estimation-error",
        "estimation-consistency",
        "v2v-load",
        "compare-speeds",
        "compare-distances",
    }


def _is_of_time(figure: Figure, axes: Any) -> bool:
    """Return whether the x-axis is time. Its label may be below another axis of the column."""
    if not axes.get_subplotspec() or axes.get_label() == "<colorbar>":
        return False
    shared = axes.get_shared_x_axes().get_siblings(axes)
    supxlabel = figure.get_supxlabel()
    return "time, s" in {supxlabel, *(one.get_xlabel() for one in shared)}


def test_names_of_files_have_one_style(runs: list[Labelled]) -> None:
    for _, run in runs:
        for section in sections_of(run):
            names = [sheet.name for sheet in section.sheets]
            for name in (*names, *(picture.name for picture in section.pictures)):
                assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name), name


def test_data_with_a_long_tail_are_on_a_logarithmic_axis(
    runs: list[Labelled], tmp_path: Path
) -> None:
    dead = """{duration_s: 20, fleet: {size: 4}, channel: {loss: {p: 0.1}, outages:
        [{from_s: 2, source: 2}]}}"""
    long = load(write_log(tmp_path / "dead.mcap", dead))
    *_, delays = comparison_pictures([runs[2], Labelled("dead", long)])
    latency, age = delays.draw().axes
    assert (latency.get_xscale(), age.get_xscale()) == ("linear", "log")
    for run, name, scale in (
        (long, "v2v-age", "log"),
        (runs[0].run, "v2v-age", "linear"),
        (runs[1].run, "v2v-latency", "log"),
        (runs[0].run, "v2v-latency", "linear"),
    ):
        pictures = [picture for section in sections_of(run) for picture in section.pictures]
        figure = next(picture for picture in pictures if picture.name == name).draw()
        assert {axes.get_xscale() for axes in figure.axes} == {scale}
