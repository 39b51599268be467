"""Shows how bilateral control degrades with the channel: a table and a figure from digests."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from zenvoy.analysis.measures.digest import Digest
from zenvoy.analysis.measures.statistics import Mean, mean_of
from zenvoy.analysis.page.section import Picture, Sheet
from zenvoy.analysis.page.style import MODEL_COLOURS, figure_legend, subplots
from zenvoy.analysis.paper.evidence import lowest, settled

MODELS: Final = ("BCM", "MBCM", "PBCM")


class Impairment(NamedTuple):
    """A property of the channel that is made worse: key, title with unit, levels, kind of axis."""

    key: str
    title: str
    levels: tuple[float, ...]
    logarithmic: bool = False


IMPAIRMENTS: Final = (
    Impairment("loss", "frames lost, %", tuple(float(p) for p in range(0, 100, 10))),
    Impairment("burst", "mean burst, frames (30 % lost)", (2, 5, 10, 20, 50, 100), True),
    Impairment("latency", "latency, ms", (10, 50, 100, 200, 300, 500, 700, 1000), True),
)


class Point(NamedTuple):
    """A point of the figure: an impairment, its level, the model, and whether fallback is allowed.

    A vehicle that falls back runs FM on its radar while its V2V data are older than the limit.
    """

    impairment: str
    level: float
    model: str
    fallback: bool


class Quantity(NamedTuple):
    """A figure of a run, and its title with the unit."""

    title: str
    of: Callable[[Digest], float]


def _end(run: Digest) -> float:
    return float(run.time_s[-1])


QUANTITIES: Final = (
    Quantity("MinDistance, m", lambda run: lowest(run, "min_distance", 0.5 * _end(run), _end(run))),
    Quantity("spread of speed, m/s", lambda run: settled(run, "spread", _end(run) - 20, _end(run))),
)


def sheet(runs: Mapping[Point, Sequence[Digest]]) -> Sheet:
    """Return a row per point: means over seeds with their 95 % intervals."""
    rows = []
    for point, of_seeds in runs.items():
        means = [mean_of([quantity.of(run) for run in of_seeds]) for quantity in QUANTITIES]
        cells = [cell for mean in means for cell in (mean.mean, _half(mean))]
        fallbacks = float(np.mean([run.facts["fallbacks"] for run in of_seeds]))
        collisions = float(np.mean([run.facts["collisions"] for run in of_seeds]))
        rows.append(
            (
                point.impairment,
                point.level,
                point.model,
                "yes" if point.fallback else "no",
                len(of_seeds),
                *cells,
                fallbacks,
                collisions,
            )
        )
    return Sheet(
        name="degradation",
        title="Degradation of bilateral control with the channel",
        columns=(
            "impairment",
            "level",
            "model",
            "fallback",
            "seeds",
            *(name for q in QUANTITIES for name in (q.title, f"± 95 %, {q.title.split(', ')[1]}")),
            "fallbacks per run",
            "collisions per run",
        ),
        rows=tuple(rows),
    )


def _half(mean: Mean) -> float | None:
    """Return half the width of the interval; None for a single seed."""
    half = 0.5 * (mean.high - mean.low)
    return None if np.isnan(half) else half


def picture(runs: Mapping[Point, Sequence[Digest]], caption: str) -> Picture:
    """Return the picture of MinDistance and spread of speed against each impairment."""
    return Picture(name="degradation", caption=caption, draw=lambda: _draw(runs))


def _draw(runs: Mapping[Point, Sequence[Digest]]) -> Figure:
    figure, axes = subplots(len(QUANTITIES), len(IMPAIRMENTS), height_in=5.0, sharex="col",
                            sharey="row")  # fmt: skip
    for row, quantity in enumerate(QUANTITIES):
        axes[row, 0].set_ylabel(quantity.title)
        for column, impairment in enumerate(IMPAIRMENTS):
            axis = axes[row, column]
            for model in MODELS:
                for fallback, style in ((True, "o-"), (False, "x--")):
                    label = f"{model}{'' if fallback else ', no fallback'}"
                    means = _means(runs, quantity, impairment, model, fallback)
                    _line(axis, impairment, means, style, model, label)
            if impairment.logarithmic:
                axis.set_xscale("log")
        axes[row, 0].set_ylim(bottom=0.0)  # intervals may reach below 0, but no quantity does
    for axis, impairment in zip(axes[-1], IMPAIRMENTS, strict=True):
        axis.set_xlabel(impairment.title)
    figure_legend(figure, axes[0, 0], ncols=3)
    return figure


def _means(
    runs: Mapping[Point, Sequence[Digest]],
    quantity: Quantity,
    impairment: Impairment,
    model: str,
    fallback: bool,
) -> list[Mean]:
    points = [Point(impairment.key, level, model, fallback) for level in impairment.levels]
    return [mean_of([quantity.of(run) for run in runs[point]]) for point in points]


def _line(
    axis: Any, impairment: Impairment, means: list[Mean], style: str, model: str, label: str
) -> None:
    axis.errorbar(
        impairment.levels,
        [mean.mean for mean in means],
        [_half(mean) or 0.0 for mean in means],
        fmt=style,
        ms=3.5,
        lw=1.0,
        capsize=2,
        color=MODEL_COLOURS[model],
        label=label,
    )
