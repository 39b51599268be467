"""Pictures of string stability: measurements are points, linear theory is grey lines."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.stability import response
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.style import (
    CYCLE,
    THEORY,
    figure_legend,
    legend,
    plain_log,
    subplots,
    whole_numbers,
)
from zenvoy.analysis.theory.chain import frequency_response
from zenvoy.analysis.theory.disturbed import Disturbed
from zenvoy.analysis.theory.ring_modes import Modes

Floats = NDArray[np.float64]

EXCITED: Final = 0.05  # share of the largest amplitude from which a frequency is shown

_MEASURED: Final = CYCLE[0]
_SETTLED: Final = 0.05  # share of its largest acceleration that a settled vehicle may have
_END: Final = 50  # the end of a record is a fiftieth of it, but at least a second
_SHOWN: Final = (1, 3, 10)  # places behind the disturbed vehicle; the last one is added
_DECADE: Final = 10.0
_SMALLEST: Final = 1e-3  # lower end of the axes: a gain, or a share of the largest amplitude


def gain_picture(case: Disturbed) -> Figure:
    """Draw L2 and L∞ norm of each vehicle's deviation relative to the disturbed vehicle."""
    figure, axes = subplots(1, 2, height_in=3.2, sharex=True)
    measured = case.gains(case.deviation)
    theory = None if case.predicted is None else case.gains(case.predicted)
    order = np.concatenate([case.forwards[:0:-1], case.backwards])
    behind = np.arange(len(order)) - (len(case.forwards) - 1)
    for one, field, title in zip(axes, ("l2", "linf"), ("L2", "L∞"), strict=True):
        shown = [getattr(measured, field)[order]]
        if theory is not None:
            shown.append(getattr(theory, field)[order])
            one.plot(behind, shown[1], color=THEORY, label="theory")
        one.plot(behind, shown[0], "o", color=_MEASURED, ms=3, label="measured")
        _scale(one, min(float(v[v > 0.0].min()) for v in shown), max(float(v.max()) for v in shown))
        one.axhline(1.0, color="black", lw=0.6, ls=":")
        one.set_ylabel(f"{title} gain of speed")
        one.set_xlabel("vehicles behind the disturbed one")
    figure_legend(figure, *axes)
    return figure


def _scale(axes: Any, low: float, high: float) -> None:
    """Use a logarithmic axis for gains that span a decade, else a linear one from 0."""
    if high < _DECADE * low:
        axes.set_ylim(0.0, 1.2 * max(high, 1.0))
    else:
        axes.set_yscale("log")
        plain_log(axes.yaxis)
        axes.set_ylim(max(_SMALLEST, 0.7 * low), 1.5 * high)


def settled(run: Run, case: Disturbed) -> NDArray[np.bool_]:
    """Return which vehicles (n,) no longer accelerate at the end of the record.

    None counts as settled where the record does not begin with the disturbance.
    """
    if not case.from_start:
        return np.zeros(run.vehicles, dtype=np.bool_)
    acceleration = np.abs(_acceleration(run, case))
    end = acceleration[-max(round(1.0 / case.period_s), len(acceleration) // _END, 1) :]
    return np.asarray(end.max(axis=0) <= _SETTLED * acceleration.max(axis=0))


def _acceleration(run: Run, case: Disturbed) -> Floats:
    return np.asarray(run.truth["acceleration"][case.rows])


def followers(run: Run, case: Disturbed) -> list[int]:
    """Return the distances behind the disturbed vehicle for which the gain is shown.

    These vehicles have settled, and their deviation is above the noise.
    """
    last = len(case.backwards) - 1
    at_rest = settled(run, case)
    usable = (case.above_noise & at_rest & at_rest[case.source])[case.backwards]
    return [k for k in sorted({*_SHOWN, last}) if 0 < k <= last and usable[k]]


def frequency_picture(run: Run, case: Disturbed) -> Figure:
    """Draw the gain over frequency from the disturbed vehicle to some behind it."""
    acceleration = _acceleration(run, case)
    figure, axes = subplots(height_in=3.4)
    highest, largest, smallest = 0.1, 1.0, 1.0
    for number, k in enumerate(followers(run, case)):
        found = response(
            acceleration[:, case.source], acceleration[:, case.backwards[k]], case.period_s, EXCITED
        )
        gain = np.abs(found.ratio)
        colour = CYCLE[number]
        axes.loglog(found.omega, gain, "o", color=colour, ms=3, label=f"{k} behind")
        highest = max(highest, float(found.omega.max()))
        largest, smallest = max(largest, float(gain.max())), min(smallest, float(gain.min()))
    if case.theory is not None and case.predicted is not None:
        _theory_lines(axes, run, case, highest)
    axes.axhline(1.0, color="black", lw=0.6, ls=":")
    axes.set_ylim(max(_SMALLEST, 0.5 * smallest), 2.0 * largest)
    axes.set_xlabel("frequency, rad/s")
    axes.set_ylabel("gain of speed")
    for axis in (axes.xaxis, axes.yaxis):
        plain_log(axis)
    legend(axes)
    return figure


def _theory_lines(axes: Any, run: Run, case: Disturbed, highest: float) -> None:
    assert case.theory is not None
    omega = np.geomspace(2.0 * np.pi / (case.time_s[-1] - case.time_s[0]), highest, 300)
    ring = run.scenario.road.type == "ring"
    gain = np.abs(frequency_response(omega, case.theory.members, case.source, ring=ring))
    for number, k in enumerate(followers(run, case)):
        label = "theory" if number == 0 else None
        axes.loglog(omega, gain[:, case.backwards[k]], color=THEORY, zorder=1, label=label)


def mode_picture(run: Run, modes: Modes) -> Figure:
    """Draw the growth rate of each mode, and the slowest mode over time."""
    figure, (left, right) = subplots(1, 2, height_in=3.2)
    theory = [(row.number, row.theory.rate) for row in modes.rows if row.theory]
    measured = [(row.number, row.measured.rate) for row in modes.rows if row.measured]
    if theory:
        left.plot(*zip(*theory, strict=True), color=THEORY, label="theory")
    if measured:
        left.plot(*zip(*measured, strict=True), "o", color=_MEASURED, ms=4, label="measured")
    left.axhline(0.0, color="black", lw=0.6, ls=":")
    left.set_xlabel("mode (number of waves round the ring)")
    left.set_ylabel("growth rate, 1/s")
    _slowest(right, modes)
    mark(right, happenings(run))
    figure_legend(figure, left, right)
    return figure


def _slowest(axes: Any, modes: Modes) -> None:
    row = modes.slowest
    assert row is not None
    size = np.abs(row.amplitude)
    step = max(1, len(size) // 250)
    theory = modes.by_theory(row)
    if theory is not None:
        until = min(len(size), 2 * row.fitted)
        axes.semilogy(modes.time_s[:until], np.abs(theory[:until]), color=THEORY)
    axes.semilogy(modes.time_s[::step], size[::step], ".", color=_MEASURED, ms=3)
    axes.axvline(
        modes.time_s[row.fitted - 1] if row.fitted else modes.time_s[0],
        color=CYCLE[1],
        lw=0.9,
        ls="--",
    )
    axes.set_ylim(_SMALLEST * float(size.max()), 2.0 * float(size.max()))
    axes.set_xlabel("time, s")
    axes.set_ylabel(f"amplitude of mode {row.number}, m")


def wave_picture(run: Run, case: Disturbed) -> Figure:
    """Draw when the dip in speed reached each vehicle, in both directions."""
    figure, axes = subplots(height_in=3.0)
    for sign, order in ((1, case.backwards), (-1, case.forwards)):
        if case.predicted is not None:
            theory = case.dips(case.predicted, order)
            axes.plot(sign * theory.steps, theory.time_s, color=THEORY, label="theory" * (sign > 0))
        found = case.dips(case.deviation, order)
        axes.plot(
            sign * found.steps,
            found.time_s,
            "o",
            color=_MEASURED,
            ms=4,
            label="measured" * (sign > 0),
        )
    whole_numbers(axes.xaxis)
    axes.set_xlabel("vehicles behind the disturbed one (negative: ahead of it)")
    axes.set_ylabel("time of the lowest speed, s")
    mark(axes, happenings(run), along="y")
    legend(axes)
    return figure
