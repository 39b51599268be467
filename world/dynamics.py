"""Exact motion of the fleet under accelerations that are constant between changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def advance(position: Floats, speed: Floats, a: Floats, dt_s: float) -> tuple[Floats, Floats]:
    """Position (m) and speed (m/s) after dt_s under constant a (m/s²), all (n,).

    A vehicle that reaches standstill stays there: speed is never below 0.
    """
    after = speed + a * dt_s
    stops = after < 0.0
    if not np.count_nonzero(stops):
        return position + speed * dt_s + 0.5 * a * (dt_s * dt_s), after
    dt = np.where(stops, -speed / np.where(stops, a, 1.0), dt_s)
    moved = position + speed * dt + 0.5 * a * (dt * dt)
    return moved, np.where(stops, 0.0, after)


def acting(speed: Floats, a: Floats) -> Floats:
    """The acceleration that acts (m/s²): braking does nothing to a vehicle that stands."""
    return np.where((speed <= 0.0) & (a < 0.0), 0.0, a)
