"""Fits the numbers of a law to a car: bounded least squares on its gaps.

It fits gaps instead of speeds or accelerations, because speeds can look right while errors of the
gap grow (Treiber and Kesting 2013, "Traffic Flow Dynamics", chapter 16).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from zenvoy.laws import Setpoint, law_of
from zenvoy.studies.convoys.following import Driven, Floats, Pair, Timing, driven
from zenvoy.studies.convoys.free import Free, values_at

_STARTS: Final = 4  # the law's own values, and points spread over the ranges
_EVALUATIONS: Final = 60  # of the gaps and their derivatives, for each start
_STEP: Final = 1e-4  # for derivatives, as a share of a number
_TOLERANCE: Final = 1e-4  # relative: the errors of a fit are told with three digits
_AT_BOUND: Final = 1e-3  # share of the range
_FAILED_M: Final = 1e3  # error of every gap where the law returns no number


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """The numbers of a law that come closest to a car, and the errors that remain.

    rms_gap_m and rms_speed_mps are root mean squares over the recording. at_bound names the numbers
    at an end of their range.
    """

    car: str
    values: Mapping[str, float]
    rms_gap_m: float
    rms_speed_mps: float
    at_bound: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A model to fit: its free numbers, the rest of its setpoint, and the timing of a vehicle."""

    model: str
    free: tuple[Free, ...]
    setpoint: Setpoint
    timing: Timing

    def drive(self, values: Mapping[str, float], pair: Pair) -> Driven:
        """Return how a vehicle with these values follows; raises what the law raises."""
        law = law_of(self.model)
        found = values_at(law, self.setpoint, list(self.free), values)
        return driven(law, found.parameters, found.setpoint, pair, self.timing)


def fitted(task: Task, pair: Pair) -> Fit:
    """Return the best of several local fits to a car."""
    low = np.array([one.low for one in task.free])
    span = np.array([one.high for one in task.free]) - low

    def values(u: Floats) -> dict[str, float]:
        numbers = (low + u * span).tolist()
        return {one.name: value for one, value in zip(task.free, numbers, strict=True)}

    def residuals(u: Floats) -> Floats:
        try:
            return np.asarray(task.drive(values(u), pair).gap - pair.gap)
        except (ArithmeticError, ValueError):
            return np.full(len(pair.gap), _FAILED_M)

    best: Any = None
    for start in _starts(task, low, span):
        found = least_squares(
            residuals,
            start,
            bounds=(0.0, 1.0),
            x_scale="jac",
            diff_step=_STEP,
            ftol=_TOLERANCE,
            xtol=_TOLERANCE,
            max_nfev=_EVALUATIONS,
        )
        best = found if best is None or found.cost < best.cost else best
    at_end = (best.x < _AT_BOUND) | (best.x > 1.0 - _AT_BOUND)
    chosen = values(best.x)
    gap, speed = errors(task, chosen, pair)
    return Fit(
        car=pair.car,
        values=chosen,
        rms_gap_m=gap,
        rms_speed_mps=speed,
        at_bound=tuple(one.name for one, end in zip(task.free, at_end, strict=True) if end),
    )


def errors(task: Task, values: Mapping[str, float], pair: Pair) -> tuple[float, float]:
    """Return the root mean squares of the errors of gap (m) and speed (m/s) with these values."""
    found = task.drive(values, pair)
    return _rms(found.gap - pair.gap), _rms(found.speed - pair.own)


def _starts(task: Task, low: Floats, span: Floats) -> list[Floats]:
    """Return points of the unit cube: the law's own values, and some that fill it evenly."""
    own = (np.array([one.start for one in task.free]) - low) / span
    spread = qmc.Halton(len(task.free), scramble=False).random(_STARTS)[1:]
    return [own, *(0.05 + 0.9 * point for point in spread)]


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
