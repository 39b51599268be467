"""Pictures of the distances between vehicles, in metres and in seconds."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.metrics import largest_gaps, smallest_gaps
from zenvoy.analysis.measures.motion import Band, over_windows
from zenvoy.analysis.measures.safety import smallest, time_headway, time_to_collision
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.style import CYCLE, THEORY, figure_legend, legend, subplots
from zenvoy.links.distance import gaps
from zenvoy.scenarios import roster

Floats = NDArray[np.float64]

THRESHOLDS_S: Final = (4.0, 1.5)  # of time to collision
WINDOW_S: Final = 10.0  # time that an error bar covers

_MIN, _MAX = CYCLE[0], CYCLE[1]
_MAX_BARS: Final = 40
LONGEST_S: Final = 100.0  # the longest time to collision that is shown
_MIN_SHARE: Final = 5.0  # %; the axis of shares reaches at least this far
_MAX_HEADWAY_S: Final = 5.0
_SLOW_MPS: Final = 0.1


def distance_bars(run: Run) -> Figure:
    """Draw MinDistance and MaxDistance over time, with error bars (paper Section IV)."""
    time_s, spacing = run.time_s, spacing_of(run.scenario)
    gap = spacing.shown(gaps(run.truth["position"], run.scenario.ring_length_m))
    width_s = max(WINDOW_S, (time_s[-1] - time_s[0]) / _MAX_BARS)
    figure, axes = subplots(height_in=3.4)
    for values, colour, label in (
        (largest_gaps(gap), _MAX, "MaxDistance"),
        (smallest_gaps(gap), _MIN, "MinDistance"),
    ):
        axes.plot(time_s, values.mean(axis=1), color=colour, lw=0.8, label=label)
        bars(axes, *over_windows(time_s, values, width_s), colour)
    mean = np.nanmean(gap, axis=1)
    axes.plot(time_s, mean, color=THEORY, lw=0.8, ls="--", label="mean gap")
    axes.set_xlim(time_s[0], time_s[-1])
    mark(axes, happenings(run))
    axes.set_xlabel("time, s")
    axes.set_ylabel(spacing.named("distance", "m"))
    legend(axes)
    return figure


def bars(axes: Any, middles_s: Floats, band: Band, colour: str) -> None:
    """Draw means ± standard deviations of windows, or of runs."""
    axes.errorbar(
        middles_s, band.mean, band.std, color=colour, ls="none", marker="o", ms=2.5, capsize=2.0
    )


def collision_time(run: Run) -> Figure:
    """Draw the smallest time to collision, and the share of vehicles below each threshold."""
    ttc = run_time_to_collision(run)
    time_s = run.time_s
    figure, (above, below) = subplots(2, height_in=4.4, sharex=True)
    above.semilogy(time_s, np.minimum(smallest(ttc), LONGEST_S), color=CYCLE[0], lw=0.8)
    highest = _MIN_SHARE
    for threshold_s, colour in zip(THRESHOLDS_S, (CYCLE[4], CYCLE[1]), strict=True):
        above.axhline(threshold_s, color=colour, lw=0.9, ls="--")
        share = 100.0 * (ttc <= threshold_s).mean(axis=1)
        below.fill_between(
            time_s, share, color=colour, lw=0.0, label=f"below {threshold_s:g} s", rasterized=True
        )
        highest = max(highest, float(share.max()))
    above.set_ylim(0.3, 1.2 * LONGEST_S)
    above.set_yticks([1.0, 10.0, 100.0], ["1", "10", "100+"])
    above.set_ylabel("smallest time\nto collision, s")
    below.set_ylabel("share of vehicles, %")
    below.set_axisbelow(True)
    below.set_ylim(0.0, 1.05 * highest)
    below.set_xlim(time_s[0], time_s[-1])
    below.set_xlabel("time, s")
    for one in (above, below):
        mark(one, happenings(run))
    figure_legend(figure, above, below)
    return figure


def headways(run: Run) -> Figure:
    """Draw the distribution of the time headway over all vehicles and times."""
    gap = gaps(run.truth["position"], run.scenario.ring_length_m)
    headway = time_headway(gap, run.truth["speed"])
    known = headway[~np.isnan(headway)]
    figure, axes = subplots(height_in=2.8)
    desired_s = _desired_s(run)
    low, high = _headway_limits(known, desired_s)
    edges = np.linspace(low, high, 101)
    weights = np.full(known.size, 100.0 / max(known.size, 1))
    axes.hist(np.clip(known, low, high), bins=edges, weights=weights, color=CYCLE[0])
    if desired_s is not None and low <= desired_s <= high:
        axes.axvline(desired_s, color=THEORY, lw=1.2, ls="--", label=f"desired: {desired_s:.2f} s")
        legend(axes)
    axes.set_axisbelow(True)
    axes.set_xlim(low, high)
    beyond = f" (the last bar is {high:g} s and more)" if (known > high).any() else ""
    axes.set_xlabel(f"time headway, s{beyond}")
    axes.set_ylabel("share of time, %")
    return figure


def _headway_limits(known: Floats, desired_s: float | None) -> tuple[float, float]:
    """Return the limits of the axis, s: all headways and the desired one, up to 5 s."""
    shown = known
    if desired_s is not None and desired_s <= _MAX_HEADWAY_S:
        shown = np.append(known, desired_s)
    shown = shown[shown <= _MAX_HEADWAY_S]
    if not shown.size:
        return 0.0, _MAX_HEADWAY_S
    margin = 0.1 * max(float(np.ptp(shown)), 0.5)
    longer = bool((known > _MAX_HEADWAY_S).any())
    high = _MAX_HEADWAY_S if longer else float(shown.max()) + margin
    return max(0.0, float(shown.min()) - margin), high


def _desired_s(run: Run) -> float | None:
    """Return desired gap over desired speed, s; None where vehicles differ or it changes."""
    desired = set()
    for settings in roster(run.scenario):
        gap, speed = settings.targets.desired_gap_m, settings.targets.desired_speed_mps
        if len(gap.points) > 1 or len(speed.points) > 1:
            return None
        desired.add(settings.desired_gap_m / max(settings.desired_speed_mps, _SLOW_MPS))
    return desired.pop() if len(desired) == 1 else None


def run_time_to_collision(run: Run) -> Floats:
    """Return the time to collision (T, n) of a run, s."""
    ring, truth = run.scenario.ring_length_m, run.truth
    gap = gaps(truth["position"], ring)
    return time_to_collision(gap, truth["speed"], run.scenario.fleet.length_m, ring)
