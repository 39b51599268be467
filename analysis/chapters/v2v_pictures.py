"""Pictures of the chapter on V2V."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, StrMethodFormatter
from numpy.typing import NDArray

from zenvoy.analysis.measures.ages import Ages
from zenvoy.analysis.measures.links import Distances, Latencies, geometric, wilson
from zenvoy.analysis.page.happenings import Happening
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.style import (
    CYCLE,
    SPEED_MAP,
    THEORY,
    figure_legend,
    is_long,
    legend,
    long_axis,
    plain_log,
    subplots,
    whole_numbers,
)

_BARS: Final = 40
_MAX_BURST_BARS: Final = 30  # longer bursts are shown as dots
_MAX_RATIO: Final = 1e4  # of the largest to the smallest latency on one axis


def draw_latency(latency: Latencies, wait_ms: float, technology: str) -> Figure:
    """Draw histogram and empirical distribution function of the latency."""
    figure, (bars, curve) = subplots(1, 2, height_in=2.8, sharex=True)
    at_ms = np.arange(len(latency.counts)) * latency.width_ns * 1e-6
    seen = np.flatnonzero(latency.counts)
    low, high = at_ms[seen[0]], at_ms[seen[-1]]
    floor = max(low, high / _MAX_RATIO)
    long = is_long(floor, high)
    edges = np.linspace(low, high, _BARS + 1) if high > low else np.array([low - 0.05, low + 0.05])
    if long:
        edges = np.geomspace(0.999 * floor, 1.001 * high, _BARS + 1)
    share = 100.0 * latency.counts[seen] / latency.counts.sum()
    bars.hist(np.maximum(at_ms[seen], edges[0]), edges, weights=share, color=CYCLE[0])
    bars.set_ylabel("frames, %")
    margin = max(0.05 * (high - low), 0.5)
    right = margin + max(high, wait_ms if wait_ms <= 2.0 * high else high)
    at = np.concatenate([[low - margin], at_ms[seen], [right]])
    reached = np.concatenate([[0.0], np.cumsum(share), [100.0]])
    curve.step(at, reached, where="post", color=CYCLE[0])
    curve.set_ylabel("frames up to this latency, %")
    if long:
        long_axis(bars, floor, max(high, wait_ms))
    else:
        bars.set_xlim(low - margin, right)
        bars.xaxis.set_major_locator(MaxNLocator(5))
    for axis in (bars, curve):
        axis.set_axisbelow(True)
        axis.axvline(wait_ms, color=THEORY, ls="--", lw=1.0, label="decision")
        axis.set_xlabel(f"latency over {technology}, ms")
        axis.set_ylim(0.0, 1.03 * axis.get_ylim()[1])
    curve.set_ylim(0.0, 103.0)
    figure_legend(figure, bars, curve)
    return _typed(figure)


def draw_delivery(found: Distances, overall: float) -> Figure:
    """Draw the share of frames delivered in each bin of distance, with its interval."""
    figure, axis = subplots(height_in=2.8)
    sent = found.sent > 0
    low, high = wilson(found.delivered, found.sent)
    middle = 0.5 * (found.edges_m[:-1] + found.edges_m[1:])[sent]
    share = found.delivered[sent] / found.sent[sent]
    error = np.abs(np.array([share - low[sent], high[sent] - share]))
    axis.axhline(100.0 * overall, color=THEORY, ls="--", lw=1.0, label="all distances")
    label = f"bins of {found.edges_m[1]:g} m"
    axis.errorbar(
        middle, 100.0 * share, 100.0 * error, fmt="o", ms=4, capsize=3, color=CYCLE[0], label=label
    )
    axis.set_xlim(0.0, found.edges_m[-1])
    bottom = float(low[sent].min())
    axis.set_ylim(100.0 * max(0.0, bottom - 0.1 * (1.0 - bottom) - 0.005), 100.5)
    axis.set_xlabel("distance, m")
    axis.set_ylabel("delivered, %")
    legend(axis)
    return _typed(figure)


def draw_load(
    busy_ratio: NDArray[np.float64], period_s: float, found: Sequence[Happening]
) -> Figure:
    """Draw the channel busy ratio over time: mean, and range over the vehicles."""
    figure, axis = subplots(height_in=2.6)
    time_s = np.arange(len(busy_ratio)) * period_s
    low, high = 100.0 * busy_ratio.min(axis=1), 100.0 * busy_ratio.max(axis=1)
    axis.fill_between(time_s, low, high, color=CYCLE[0], alpha=0.3, lw=0, label="all vehicles")
    axis.plot(time_s, 100.0 * busy_ratio.mean(axis=1), color=CYCLE[0], lw=1.2, label="mean")
    axis.set_ylim(0.0, min(100.0, 1.15 * float(high.max()) + 1.0))
    axis.set_xlim(0.0, max(float(time_s[-1]), period_s))
    axis.set_xlabel("time, s")
    axis.set_ylabel("channel busy ratio, %")
    mark(axis, found)
    legend(axis)
    return _typed(figure)


def draw_ages(counts: Mapping[str, NDArray[np.int64]], period_ms: float, limit_ms: float) -> Figure:
    """Draw the share of decisions with at most each age, and with a higher one (logarithmic)."""
    figure, (curve, tail) = subplots(1, 2, height_in=2.8, sharex=True)
    longest = max(len(count) for count in counts.values())
    for number, (name, count) in enumerate(counts.items()):
        total = count.sum()
        if not total:
            continue
        at_ms = np.arange(longest + 1) * period_ms
        not_older = np.concatenate([count, np.zeros(longest + 1 - len(count))]).cumsum() / total
        look = {
            "color": CYCLE[number],
            "ls": ("-", "--", ":")[number % 3],
            "lw": 1.8 - 0.3 * number,
        }
        curve.step(at_ms, 100.0 * not_older, where="post", label=name, **look)
        older = np.where(not_older < 1.0, 1.0 - not_older, np.nan)
        tail.step(at_ms, 100.0 * older, where="post", **look)
    tail.set_yscale("log")
    plain_log(tail.yaxis)
    curve.set_ylabel("decisions up to this age, %")
    tail.set_ylabel("decisions above this age, %")
    curve.set_ylim(0.0, 103.0)
    for axis in (curve, tail):
        axis.set_xlabel("age of information, ms")
        long_axis(axis, period_ms, longest * period_ms)
        if limit_ms <= longest * period_ms:
            axis.axvline(limit_ms, color=THEORY, ls="--", lw=1.0, label="age limit")
    figure_legend(figure, curve, tail)
    return _typed(figure)


def draw_age_map(aged: Ages, vehicles: int, period_ms: float) -> Figure:
    """Draw the mean age by source and destination."""
    figure, axis = subplots(height_in=4.6)
    image = np.full((vehicles, vehicles), np.nan)
    image[aged.destination - 1, aged.source - 1] = aged.mean() * period_ms
    colours = mpl.colormaps[SPEED_MAP].with_extremes(bad="#DDDDDD")
    known = image[~np.isnan(image)]
    top = max(float(np.percentile(known, 99.0)), 0.01 * period_ms)
    extent = (0.5, vehicles + 0.5, 0.5, vehicles + 0.5)
    shown = axis.imshow(
        image, origin="lower", extent=extent, cmap=colours, vmin=0.0, vmax=top, interpolation="none"
    )
    extend = "max" if known.max() > top else "neither"
    figure.colorbar(shown, ax=axis, label="mean age, ms", extend=extend)
    axis.grid(visible=False)
    axis.set_xlabel("sending vehicle")
    axis.set_ylabel("receiving vehicle")
    whole_numbers(axis.xaxis, axis.yaxis)
    return _typed(figure)


def draw_bursts(bursts: NDArray[np.int64], loss_ratio: float) -> Figure:
    """Draw the share of bursts by length, with the geometric law; as dots if some are long."""
    figure, axis = subplots(height_in=2.8)
    length = np.flatnonzero(bursts)
    share = 100.0 * bursts[length] / bursts.sum()
    if length[-1] <= _MAX_BURST_BARS:
        axis.bar(length, share, width=0.7, color=CYCLE[0], label="logged")
        axis.set_xlim(0.4, max(length[-1] + 0.6, 4.6))
        whole_numbers(axis.xaxis)
    else:
        axis.plot(length, share, "o", ms=3, color=CYCLE[0], label="logged")
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    lowest = 0.5 * share.min()
    expected = 100.0 * geometric(loss_ratio, length[-1])
    law = np.flatnonzero(expected > 0.1 * lowest)
    axis.plot(law, expected[law], "o-", ms=3, color=CYCLE[1], label="independent losses")
    axis.set_axisbelow(True)
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_ylim(lowest, 150.0)
    axis.set_xlabel("frames lost in a row")
    axis.set_ylabel("bursts, %")
    legend(axis)
    return _typed(figure)


def _typed(figure: Any) -> Figure:
    assert isinstance(figure, Figure)
    return figure
