"""Pictures of several runs on the same axes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from zenvoy.analysis.log.arrays import read_frames
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.distribution import Steps, steps
from zenvoy.analysis.measures.instants import instants_s, row_at
from zenvoy.analysis.measures.metrics import max_distance, min_distance
from zenvoy.analysis.measures.spacing import Spacing, together
from zenvoy.analysis.page import style
from zenvoy.analysis.page.happenings import Happening, happenings
from zenvoy.analysis.page.marks import ABOVE_BARS_PT, mark
from zenvoy.analysis.page.section import Picture
from zenvoy.analysis.page.speed_map import speed_map
from zenvoy.links.distance import gaps
from zenvoy.scenarios import roster

_LINES: Final = ("-", "--", ":", "-.")


class Labelled(NamedTuple):
    """A run with its name in the comparison."""

    label: str
    run: Run


def comparison_pictures(runs: Sequence[Labelled]) -> tuple[Picture, ...]:
    """Return pictures of speeds, distances and snapshots, and of latency and age if known."""
    pictures = [
        Picture(
            name="compare-speeds",
            caption="Speed of every vehicle over time, with one colour scale for all runs. A wave "
            "shows as a band that crosses the vehicles. Bars above the panels mark brakes, traces, "
            "manoeuvres and changes of the channel.",
            draw=partial(_speeds, runs),
        ),
        Picture(
            name="compare-distances",
            caption="MaxDistance and MinDistance over time: the means of the three largest and the "
            f"three smallest gaps{_of_gaps(runs)}. The closer the two are, the more even are the "
            "gaps.",
            draw=partial(_distances, runs),
        ),
        Picture(
            name="compare-snapshots",
            caption="Speed of every vehicle at some instants from the first disturbance on, or "
            "from the start if there is none. A level line is a string without a wave.",
            draw=partial(_snapshots, runs),
        ),
    ]
    distributions = [_latencies(runs), _ages(runs)]
    if any(steps is not None for of_runs in distributions for steps in of_runs):
        pictures.append(
            Picture(
                name="compare-delays",
                caption="Share of frames with at most this latency (left), and share of decisions "
                "for which the data of the vehicle behind have at most this age (right). Curves "
                "further to the left are better.",
                draw=partial(_delays, runs, distributions),
            )
        )
    return tuple(pictures)


def colours(runs: Sequence[Labelled]) -> list[str]:
    """Return a colour per run: that of its last model if these all differ, or else in turn."""
    last = [{settings.phases[-1].model for settings in roster(run.scenario)} for _, run in runs]
    models = [model for of_run in last for model in of_run]
    if len(models) == len(set(models)) == len(runs):
        own = {law.reference: law.colour for _, run in runs for law in run.laws.values()}
        found = [own.get(model) for model in models]
        if None not in found:
            return [colour for colour in found if colour is not None]
    return [style.CYCLE[number % len(style.CYCLE)] for number in range(len(runs))]


def _lines(runs: Sequence[Labelled]) -> list[dict[str, Any]]:
    """Return each run's line style: colour, dashes once colours repeat, label."""
    return [
        {
            "color": colour,
            "linestyle": _LINES[number // len(style.CYCLE) % len(_LINES)],
            "label": style.plain(runs[number].label),
        }
        for number, colour in enumerate(colours(runs))
    ]


def _shared(runs: Sequence[Labelled]) -> list[Happening]:
    """Return what happened at the same time in all runs."""
    first, *others = (happenings(run) for _, run in runs)
    return [each for each in first if all(_same(each, other) for other in others)]


def _same(happening: Happening, others: Sequence[Happening]) -> bool:
    return any(happening[:3] == other[:3] for other in others)


def _speeds(runs: Sequence[Labelled]) -> Figure:
    columns = 1 if len(runs) <= 3 else 2
    rows = -(-len(runs) // columns)
    figure, grid = style.subplots(
        rows, columns, height_in=0.7 + 1.7 * rows, sharex=True, sharey=True, squeeze=False
    )
    speeds = [run.truth["speed"] for _, run in runs]
    scale = Normalize(min(s.min() for s in speeds), max(s.max() for s in speeds))
    last_s = max(run.time_s[-1] for _, run in runs)
    most = max(run.vehicles for _, run in runs)
    for axes, (label, run), speed in zip(grid.flat, runs, speeds, strict=False):
        speed_map(axes, run.time_s, speed, scale)
        axes.set_title(style.plain(label), loc="left", pad=ABOVE_BARS_PT)
        axes.set(xlim=(0.0, last_s), ylim=(0.5, most + 0.5))
        mark(axes, happenings(run), image=True)
    for axes in grid.flat[len(runs) :]:
        axes.set_visible(False)
    figure.colorbar(ScalarMappable(scale, style.SPEED_MAP), ax=grid, label="speed, m/s")
    style.figure_legend(figure, *grid.flat[: len(runs)])
    figure.supxlabel("time, s", fontsize="medium")
    figure.supylabel("vehicle", fontsize="medium")
    return figure


def spacings(runs: Sequence[Labelled]) -> list[Spacing]:
    """Return how the gaps of each run are shown beside the others."""
    return together([run.scenario for _, run in runs])


def _of_gaps(runs: Sequence[Labelled]) -> str:
    words = spacings(runs)[0].words
    return f", {words}" if words else ""


def _distances(runs: Sequence[Labelled]) -> Figure:
    figure, pair = style.subplots(2, 1, height_in=4.6, sharex=True)
    shown = spacings(runs)
    for (_, run), look, spacing in zip(runs, _lines(runs), shown, strict=True):
        gap = spacing.shown(gaps(run.truth["position"], run.scenario.ring_length_m))
        for axes, distance in zip(pair, (max_distance, min_distance), strict=True):
            axes.plot(run.time_s, distance(gap), lw=1.0, **look)
    for axes, name in zip(pair, ("MaxDistance", "MinDistance"), strict=True):
        axes.set_ylabel(shown[0].named(name, "m"))
    pair[1].set_xlabel("time, s")
    pair[1].set_xlim(0.0, max(run.time_s[-1] for _, run in runs))
    for axes in pair:
        mark(axes, _shared(runs))
    style.figure_legend(figure, *pair)
    return figure


def _snapshots(runs: Sequence[Labelled]) -> Figure:
    instants = instants_s([run for _, run in runs])
    columns = min(3, len(instants))
    rows = -(-len(instants) // columns)
    figure, grid = style.subplots(
        rows, columns, height_in=0.6 + 1.7 * rows, sharex=True, sharey=True, squeeze=False
    )
    for axes, at_s in zip(grid.flat, instants, strict=False):
        for (_, run), look in zip(runs, _lines(runs), strict=True):
            row = row_at(run.time_s, at_s)
            vehicles = np.arange(1, run.vehicles + 1)
            axes.plot(vehicles, run.truth["speed"][row], marker=".", ms=3, lw=0.8, **look)
        axes.set_title(f"{at_s:g} s", loc="left")
        style.whole_numbers(axes.xaxis)
    for axes in grid.flat[len(instants) :]:
        axes.set_visible(False)
    figure.supxlabel("vehicle", fontsize="medium")
    figure.supylabel("speed, m/s", fontsize="medium")
    style.figure_legend(figure, grid[0, 0])
    return figure


def _latencies(runs: Sequence[Labelled]) -> list[Steps | None]:
    """Return the distribution of the latency of delivered frames, ms, for each run."""
    found = []
    for _, run in runs:
        tables = [table["latency_ns"] for table in read_frames(run.log)]
        latency = np.concatenate([np.zeros(0, np.int64), *(t[t >= 0] for t in tables)])
        found.append(steps(latency * 1e-6))
    return found


def _ages(runs: Sequence[Labelled]) -> list[Steps | None]:
    """Return the distribution of the age of data from the vehicle behind, ms, for each run."""
    ages = [run.estimate["age_ns"] for _, run in runs]
    return [steps(age[age >= 0] * 1e-6) for age in ages]


def _delays(runs: Sequence[Labelled], distributions: Sequence[list[Steps | None]]) -> Figure:
    figure, pair = style.subplots(1, 2, height_in=2.8, sharey=True)
    for axes, of_runs in zip(pair, distributions, strict=True):
        known = np.concatenate([[], *(found.values for found in of_runs if found)])
        high = float(known.max(initial=0.0))
        low = float(known.min(initial=high, where=known > 0.0))
        for found, look in zip(of_runs, _lines(runs), strict=True):
            values, share = found or Steps(np.zeros(0), np.zeros(0))
            # The curve begins at 0 % below the smallest value and ends at 100 % above the largest.
            x, y = [0.0, *values, 2.0 * high], [0.0, *(100.0 * share), 100.0]
            axes.step(x if found else [], y if found else [], where="post", **look)
        style.long_axis(axes, low, high)
    pair[0].set(
        xlabel="latency of a frame, ms", ylabel="share up to this value, %", ylim=(0.0, 102.0)
    )
    pair[1].set_xlabel("age of the data of the vehicle behind, ms")
    style.figure_legend(figure, *pair)
    return figure
