"""Draws the paper's figures from the evidence."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.instants import PAPER_S
from zenvoy.analysis.measures.statistics import mean_and_half
from zenvoy.analysis.page.speed_map import speed_map
from zenvoy.analysis.page.style import (
    ESTIMATED,
    MEASURED,
    MODEL_COLOURS,
    TRUE,
    figure_legend,
    subplots,
)
from zenvoy.analysis.paper.evidence import PAIRS, Evidence, Pair, case

Floats = NDArray[np.float64]

_LARGE_ERROR: Final = Pair(0.10, 0.1)  # cases 3, 7, 11, 15, which the paper shows most often
_BILATERAL: Final = ("BCM", "MBCM", "PBCM")
_EQUAL_GAP_M: Final = 37.5
_STEP: Final = 5  # every fifth row of a digest is drawn


def error_reduction(evidence: Evidence) -> Figure:
    """Draw Fig. k_1 to k_4: the readings that BCM acts on, and the estimates that PBCM acts on."""
    figure, axes = subplots(2, 2, height_in=5.0, sharex=True, sharey="row")
    bcm, pbcm = evidence[case("BCM", _LARGE_ERROR)][0], evidence[case("PBCM", _LARGE_ERROR)][0]
    vehicle = pbcm.facts["vehicle"]
    names = ("speed, m/s", "gap ahead, m")
    for row, (first, name) in enumerate(zip((0, 3), names, strict=True)):
        _pair(axes[row, 0], bcm, first, first + 1, MEASURED, "measured")
        _pair(axes[row, 1], pbcm, first, first + 2, ESTIMATED, "estimated")
        axes[row, 0].set_ylabel(f"vehicle {vehicle}: {name}")
    axes[0, 0].set_title("BCM (case 7)")
    axes[0, 1].set_title("PBCM (case 15)")
    for below in axes[1]:
        below.set_xlabel("time, s")
    figure_legend(figure, *axes.flat, markerscale=3)
    return figure


def _pair(axes: Any, run: Digest, true: int, other: int, colour: str, name: str) -> None:
    shown = run.time_s[: run.link.shape[1]] <= 60.0
    time_s = run.time_s[: len(shown)][shown]
    axes.plot(time_s, run.link[other][shown], ".", ms=2.5, color=colour, label=name)
    axes.plot(time_s, run.link[true][shown], color=TRUE, lw=1.2, label="true")


def snapshots(evidence: Evidence) -> Figure:
    """Draw the speed of every vehicle at 9, 30, 100 and 300 s (10 %, 0.1 s)."""
    figure, axes = subplots(2, 2, height_in=4.8, sharex=True, sharey=True)
    for row, at_s, place in zip(range(4), PAPER_S, axes.flat, strict=True):
        for model in ("FM", *_BILATERAL):
            speed = evidence[case(model, _LARGE_ERROR)][0].snapshots[row]
            vehicles = np.arange(1, len(speed) + 1)
            place.plot(vehicles, speed, ".-", ms=3, lw=0.8, color=MODEL_COLOURS[model], label=model)
        place.set_title(f"{at_s:g} s")
    for place in axes[1]:
        place.set_xlabel("vehicle")
    for place in axes[:, 0]:
        place.set_ylabel("speed, m/s")
    axes[0, 0].set_ylim(bottom=-1.0)
    figure_legend(figure, axes[0, 0])
    return figure


def heat_maps(evidence: Evidence) -> Figure:
    """Draw speed over time and vehicle for PBCM, MBCM, BCM and FM (10 %, 0.1 s).

    FM has its own scale, on which the other models would have a single colour.
    """
    figure, axes = subplots(4, 1, height_in=7.6, sharex=True)
    spans = {"PBCM": (28.0, 32.0), "MBCM": (28.0, 32.0), "BCM": (28.0, 32.0), "FM": (0.0, 60.0)}
    for place, (model, (low, high)) in zip(axes, spans.items(), strict=True):
        run = evidence[case(model, _LARGE_ERROR)][0]
        image = speed_map(place, run.time_s, run.speed, Normalize(low, high))
        place.set_title(f"{model}, case {int(case(model, _LARGE_ERROR))}")
        place.set_ylabel("vehicle")
        if model in {"BCM", "FM"}:  # the last model on each scale
            of = axes[:3] if model == "BCM" else axes[3:]
            figure.colorbar(
                image, ax=list(of), label="speed, m/s", extend="both", aspect=12 * len(of)
            )
    axes[-1].set_xlabel("time, s")
    return figure


def min_distances(evidence: Evidence) -> Figure:
    """Draw MinDistance over time, as mean over the seeds, for each pair of error and delay."""
    figure, axes = subplots(2, 2, height_in=5.2, sharex=True, sharey=True)
    for pair, place in zip(PAIRS, (axes[0, 0], axes[1, 0], axes[0, 1], axes[1, 1]), strict=True):
        _means(place, evidence, pair, "min_distance")
        place.set_title(pair.title)
    for place in axes[1]:
        place.set_xlabel("time, s")
    for place in axes[:, 0]:
        place.set_ylabel("MinDistance, m")
    figure_legend(figure, axes[0, 0])
    return figure


def _means(axes: Any, evidence: Evidence, pair: Pair, name: str) -> None:
    axes.axhline(_EQUAL_GAP_M, color="#BBBBBB", lw=0.8, ls=":")
    for model in _BILATERAL:
        label = case(model, pair)
        time_s = evidence[label][0].time_s[::_STEP]
        mean, half = mean_and_half(evidence.series(label, name)[:, ::_STEP])
        colour = MODEL_COLOURS[model]
        axes.fill_between(time_s, mean - half, mean + half, color=colour, alpha=0.25, lw=0)
        axes.plot(time_s, mean, color=colour, lw=0.9, label=model)


def min_distance_bars(evidence: Evidence) -> Figure:
    """Draw MinDistance with error bars, for the largest and the smallest error and delay."""
    figure, axes = subplots(1, 2, height_in=3.0, sharey=True)
    for pair, place in zip((PAIRS[3], PAIRS[0]), axes, strict=True):
        _bars(place, evidence, pair, "min_distance")
        place.set_title(pair.title)
        place.set_xlabel("time, s")
    axes[0].set_ylabel("MinDistance, m")
    figure_legend(figure, axes[0])
    return figure


def _bars(axes: Any, evidence: Evidence, pair: Pair, name: str, width_s: float = 25.0) -> None:
    """Draw mean and standard deviation over the seeds and over `width_s` of time."""
    for shift, model in enumerate(_BILATERAL):
        label = case(model, pair)
        time_s, values = evidence[label][0].time_s, evidence.series(label, name)
        edges = np.arange(0.0, time_s[-1] + 1e-6, width_s)
        spans = [values[:, (time_s >= low) & (time_s < low + width_s)] for low in edges[:-1]]
        axes.errorbar(
            edges[:-1] + width_s / 2 + 3.0 * (shift - 1),
            [span.mean() for span in spans],
            [span.std() for span in spans],
            fmt="o-",
            ms=2.5,
            lw=0.9,
            capsize=1.5,
            color=MODEL_COLOURS[model],
            label=model,
        )


def max_distances(evidence: Evidence) -> Figure:
    """Draw MaxDistance over time, and with error bars (10 %, 0.1 s)."""
    figure, axes = subplots(1, 2, height_in=3.0, sharey=True)
    _means(axes[0], evidence, _LARGE_ERROR, "max_distance")
    _bars(axes[1], evidence, _LARGE_ERROR, "max_distance")
    axes[0].set_ylabel("MaxDistance, m")
    figure_legend(figure, axes[0])
    for place in axes:
        place.set_xlabel("time, s")
    figure.suptitle(_LARGE_ERROR.title)
    return figure
