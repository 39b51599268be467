"""Exact motion of the fleet under accelerations that are constant between changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def advance(position: Floats, speed: Floats, a: Floats, dt_s: float) -> tuple[Floats, Floats]:
    """Return position (m) and speed (m/s) after dt_s at constant a (m/s²), all (…, n).

    A vehicle that comes to a standstill stays there: the speed is never below 0.
    """
    after = speed + a * dt_s
    stops = after < 0.0
    if not np.count_nonzero(stops):
        return position + speed * dt_s + 0.5 * a * (dt_s * dt_s), after
    dt = np.where(stops, -speed / np.where(stops, a, 1.0), dt_s)
    moved = position + speed * dt + 0.5 * a * (dt * dt)
    return moved, np.where(stops, 0.0, after)


def acting(speed: Floats, a: Floats) -> Floats:
    """Return the acceleration that acts (m/s²): a vehicle at standstill cannot brake."""
    return np.where((speed <= 0.0) & (a < 0.0), 0.0, a)
