"""Draws the overview of a run."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.instants import around_first
from zenvoy.analysis.measures.metrics import max_distance, min_distance
from zenvoy.analysis.measures.quantities import first_disturbed
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.page import style
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import ABOVE_BARS_PT, mark
from zenvoy.analysis.page.speed_map import speed_map
from zenvoy.links.distance import gaps

_LEAD_S: Final = 5.0  # the link is shown from this long before the first disturbance
_SPAN_S: Final = 60.0
_MAX_DOTS: Final = 1_500  # more are rasterised, as they would make a drawing large


def overview(run: Run) -> Figure:
    """Draw the speed of every vehicle, MinDistance and MaxDistance, and one gap with its estimate.

    The run must have a cycle.
    """
    figure, (heat, distance, link) = style.subplots(3, 1, height_in=8.2)
    gap = gaps(run.truth["position"], run.scenario.ring_length_m)
    _speeds(figure, heat, run.time_s, run.truth["speed"])
    _distances(distance, run, gap)
    _one_link(link, run, gap)
    found = happenings(run)
    for axes in (heat, distance, link):
        mark(axes, found, image=axes is heat)
        above_pt = ABOVE_BARS_PT if axes is heat else 2.0
        style.legend(axes, above_pt=above_pt, markerscale=2)
    title = f"{run.name}, seed {run.seed}, {run.vehicles} vehicles"
    heat.set_title(style.plain(title), loc="left", pad=ABOVE_BARS_PT)
    return figure


def _speeds(figure: Figure, axes: Any, time_s: NDArray[Any], speed: NDArray[Any]) -> None:
    image = speed_map(axes, time_s, speed)
    figure.colorbar(image, ax=axes, label="speed, m/s")
    axes.set_xlabel("time, s")
    axes.set_ylabel("vehicle")


def _distances(axes: Any, run: Run, gap: NDArray[Any]) -> None:
    time_s, spacing = run.time_s, spacing_of(run.scenario)
    gap = spacing.shown(gap)
    axes.plot(time_s, max_distance(gap), color=style.CYCLE[1], lw=0.9, label="MaxDistance")
    axes.plot(time_s, min_distance(gap), color=style.CYCLE[0], lw=0.9, label="MinDistance")
    axes.set_xlim(time_s[0], time_s[-1])
    axes.set_xlabel("time, s")
    axes.set_ylabel(spacing.named("mean of three gaps", "m"))


def _one_link(axes: Any, run: Run, gap: NDArray[Any]) -> None:
    """Draw the gap ahead of the first disturbed vehicle's follower, around the disturbance."""
    vehicle = first_disturbed(run) % run.vehicles + 1
    if np.isnan(gap[0, vehicle - 1]):  # the first vehicle of the open road has no gap
        vehicle = 2
    spacing = spacing_of(run.scenario)
    start_s, end_s = around_first(run, _LEAD_S, _SPAN_S)
    time_s = run.time_s[: run.cycles]
    shown = np.flatnonzero((time_s >= start_s) & (time_s <= end_s))
    if shown.size:
        time_s, column = time_s[shown], vehicle - 1
        found = (run.radar["gap"], gap, run.estimate["ahead_gap"])
        read, true, estimated = (spacing.shown(one[shown, column]) for one in found)
        many = shown.size > _MAX_DOTS
        axes.plot(time_s, read, ".", color=style.MEASURED, ms=3, label="measured", rasterized=many)
        axes.plot(time_s, true, color=style.TRUE, lw=1.6, label="true")
        if not np.isnan(estimated).all():  # only laws that predict have estimates
            axes.plot(time_s, estimated, color=style.ESTIMATED, lw=1.0, label="estimated")
        axes.set_xlim(start_s, start_s + _SPAN_S if len(shown) == 1 else time_s[-1])
    axes.set_xlabel("time, s")
    axes.set_ylabel(spacing.named(f"gap ahead of vehicle {vehicle}", "m"))
