"""The figures of a live table: what the samples of a run and its last decisions come to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.view.picture import COLUMNS, TOTALS, Picture

BLOCKS: Final = "▁▂▃▄▅▆▇█"
PLAIN: Final = "_.-=+*%#"
"""For terminals whose encoding lacks BLOCKS."""
_RECENT: Final = 20  # samples over which the pace is measured
_NAMED: Final = 3  # vehicles


class Measure(NamedTuple):
    """A row of the table: its newest value, the worst of all samples, and all samples."""

    name: str
    unit: str
    now: float
    worst: float
    values: NDArray[np.float64]


class Figures(NamedTuple):
    """What a live table shows. `late` has vehicles and the age of their data, s, oldest first."""

    real_time_factor: float
    measures: tuple[Measure, ...]
    late: tuple[tuple[int, float], ...]
    modes: dict[int, int]


def figures_of(
    samples: Mapping[str, NDArray[Any]], decided: Picture | None, period_s: float
) -> Figures:
    """Return the figures from an overview's samples, and from the last cycle with decisions."""
    totals = dict(zip(TOTALS, samples["totals"].T.astype(np.float64), strict=True))
    sent = totals["delivered"] + totals["late"] + totals["lost"] + totals["collided"]
    missed = totals["lost"] + totals["collided"]
    gap = np.where(np.isfinite(totals["smallest_gap"]), totals["smallest_gap"], np.nan)
    oldest = np.where(totals["oldest"] < 0, np.nan, totals["oldest"])
    measures = (
        _measure("mean speed", "m/s", totals["mean_speed"], np.min),
        _measure("smallest gap", "m", gap, np.min),
        _measure("oldest data", "s", oldest, np.max),
        _measure("frames lost", "%", 100 * _share(missed, sent), np.max),
        _measure("frames late", "%", 100 * _share(totals["late"], sent), np.max),
    )
    late: tuple[tuple[int, float], ...] = ()
    modes: dict[int, int] = {}
    if decided is not None:
        columns = dict(zip(COLUMNS, decided.columns, strict=True))
        age, mode = columns["age"], columns["mode"]
        known = np.flatnonzero(age > period_s)
        order = known[np.argsort(-age[known], kind="stable")][:_NAMED]
        late = tuple((int(index) + 1, float(age[index])) for index in order)
        found, counts = np.unique(mode[np.isfinite(mode)].astype(int), return_counts=True)
        modes = dict(zip(found.tolist(), counts.tolist(), strict=True))
    return Figures(_pace(samples["cycle"], totals["wall"], period_s), measures, late, modes)


def sparkline(values: NDArray[np.float64], width: int, signs: str = BLOCKS) -> str:
    """Return at most `width` signs for the values, from the lowest to the highest of them.

    Where there are more values than signs, a sign is for the mean of several; a space is for none.
    """
    means = []
    for part in np.array_split(values, min(width, len(values)) or 1):
        finite = part[np.isfinite(part)]
        means.append(finite.mean() if len(finite) else np.nan)
    heights = np.array(means)
    finite = heights[np.isfinite(heights)]
    if not len(finite):
        return " " * len(heights)
    low, span = finite.min(), np.ptp(finite)
    top = len(signs) - 1
    return "".join(
        " " if np.isnan(height) else signs[round(top * (height - low) / span) if span else 0]
        for height in heights
    )


def _measure(name: str, unit: str, values: NDArray[np.float64], worst: Any) -> Measure:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Measure(name, unit, np.nan, np.nan, values)
    return Measure(name, unit, float(finite[-1]), float(worst(finite)), values)


def _share(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    shares: NDArray[np.float64] = np.full(len(whole), np.nan)
    np.divide(part, whole, out=shares, where=whole > 0)
    return shares


def _pace(cycle: NDArray[Any], wall_s: NDArray[np.float64], period_s: float) -> float:
    """Return simulated time per wall time over the newest samples; NaN where it is unknown."""
    known = np.flatnonzero(np.isfinite(wall_s))[-_RECENT:]
    if len(known) < 2 or wall_s[known[-1]] <= wall_s[known[0]]:
        return float("nan")
    cycles = float(cycle[known[-1]]) - float(cycle[known[0]])
    return cycles * period_s / float(wall_s[known[-1]] - wall_s[known[0]])
