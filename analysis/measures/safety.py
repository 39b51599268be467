"""Time to collision and time headway. Axis 0 is time, axis 1 is the vehicle.

Gaps are from front to front, as everywhere in Zenvoy; the gap between bumpers is shorter by a
vehicle's length.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_STANDS_MPS: Final = 0.1  # below this a vehicle counts as standing, and has no headway


def time_to_collision(
    gap: Floats, speed: Floats, length_m: float, ring_length_m: float | None
) -> Floats:
    """Return the time until a vehicle hits the one ahead if both keep their speeds (T, n), s.

    It is infinite where the gap does not close, and NaN where no vehicle is ahead.
    """
    ahead = np.roll(speed, 1, axis=1)
    if ring_length_m is None:
        ahead[:, 0] = np.nan
    closing = speed - ahead
    apart = np.maximum(gap - length_m, 0.0)
    closes = closing > 0.0
    time = np.where(closes, apart / np.where(closes, closing, 1.0), np.inf)
    return np.where(np.isnan(gap), np.nan, time)


def smallest(time_to_collision_s: Floats) -> Floats:
    """Return the fleet's smallest time to collision at each time (T,), s; infinite for none."""
    return np.asarray(np.fmin.reduce(time_to_collision_s, axis=1, initial=np.inf))


def time_exposed(time_to_collision_s: Floats, threshold_s: float, period_s: float) -> float:
    """Return TET, s: the time that vehicles spend below the threshold, summed over vehicles.

    Minderhoud and Bovy (2001), "Extended time-to-collision measures for road traffic safety
    assessment". Each row counts for a period.
    """
    return float((time_to_collision_s <= threshold_s).sum() * period_s)


def time_integrated(time_to_collision_s: Floats, threshold_s: float, period_s: float) -> float:
    """Return TIT, s²: the integral of threshold minus time to collision while positive (ibid.)."""
    below = threshold_s - time_to_collision_s
    return float(np.where(below > 0.0, below, 0.0).sum() * period_s)


def share_below(time_to_collision_s: Floats, threshold_s: float) -> float:
    """Return the share of time below the threshold, over vehicles that have one ahead."""
    known = ~np.isnan(time_to_collision_s)
    if not known.any():
        return 0.0
    return float((time_to_collision_s[known] <= threshold_s).mean())


def time_headway(gap: Floats, speed: Floats) -> Floats:
    """Return the time after which a vehicle is where the one ahead is now (T, n), s.

    It is NaN where no vehicle is ahead, and for vehicles that stand.
    """
    moves = speed > _STANDS_MPS
    return np.where(moves, gap / np.where(moves, speed, 1.0), np.nan)
