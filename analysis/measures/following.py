"""Measures of following: how even the gaps of a fleet are, and how swings of speed travel.

Axis 0 is time, axis 1 is the vehicle.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.motion import jerk, rms
from zenvoy.analysis.measures.spans import first_disturbance
from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]

_STEADY_MPS: Final = 1e-6  # a speed that swings by less is constant, up to rounding


def gap_error(gap: Floats) -> float:
    """Return the RMS of gaps (T, n) minus their mean at the same time, m, over times and vehicles.

    The gap of a vehicle without one ahead is NaN.
    """
    known = gap[:, ~np.isnan(gap).any(axis=0)]
    return rms(known - known.mean(axis=1, keepdims=True))


def swing_ratio(head: Floats, tail: Floats) -> float | None:
    """Return the standard deviation of the tail's speed (T,) over that of the head's.

    It is None where the head's speed does not vary.
    """
    swing = float(head.std())
    return float(tail.std()) / swing if swing > _STEADY_MPS else None


def ends(run: Run) -> tuple[int, int, float] | None:
    """Return the columns of head and tail of a run, and the time (s) when the head is disturbed.

    The head is the vehicle that first brakes or follows a trace, or else the first vehicle of an
    open road. The tail is the last vehicle that follows it. The result is None if no vehicle
    follows the head.
    """
    first, ring = first_disturbance(run.events), run.scenario.road.type == "ring"
    if first is None:
        return None if ring else (0, run.vehicles - 1, 0.0)
    head = first.vehicle - 1
    tail = (head - 1) % run.vehicles if ring else run.vehicles - 1
    return (head, tail, first.start_s) if tail != head else None


def following(run: Run) -> dict[str, float | None]:
    """Return the figures of a run whose truth is known; None for those that do not apply."""
    truth, period_s = run.truth, run.scenario.period_ns * 1e-9
    acceleration = truth["acceleration"][1:]  # row k is the mean over the period before t_k
    changes = jerk(acceleration, period_s) if len(acceleration) > 1 else acceleration[:0]
    return {
        "gap_error_rms_m": gap_error(gaps(truth["position"], run.scenario.ring_length_m)),
        **_swings(run),
        "acceleration_rms_mps2": rms(acceleration) if acceleration.size else None,
        "jerk_rms_mps3": rms(changes) if changes.size else None,
    }


def _swings(run: Run) -> dict[str, float | None]:
    """Return how much the speed of the tail swings, m/s, and its ratio to that of the head."""
    swing_mps = ratio = None
    if (found := ends(run)) is not None:
        head, tail, start_s = found
        speed = run.truth["speed"][run.time_s >= start_s - 1e-9]
        if len(speed):
            swing_mps = float(speed[:, tail].std())
            ratio = swing_ratio(speed[:, head], speed[:, tail])
    return {"tail_speed_swing_mps": swing_mps, "speed_swing_ratio": ratio}
