"""Events of braking, as a driver's foot on the pedal makes them."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BRAKES_MPS2: Final = 1.0
"""A vehicle that slows down harder than this brakes; coasting and sensor errors stay below."""


def brakings(acceleration: Floats) -> Floats:
    """Return how many vehicles begin to brake in each row of accelerations (T, n), m/s²: (T,)."""
    brakes = acceleration < -BRAKES_MPS2
    begins = brakes & ~np.vstack([np.zeros_like(brakes[:1]), brakes[:-1]])
    return np.asarray(begins.sum(axis=1), dtype=np.float64)
