"""Gaps and distances along the road, on a ring and on an open road.

A gap reaches from a vehicle forward to the one that it follows, and counts laps: on a ring the gaps
add up to its length. A distance is the shorter way between any two vehicles. Positions are m along
the road, not wrapped. `ring_length_m` is None on an open road.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def gaps(position: Floats, ring_length_m: float | None) -> Floats:
    """Return the gaps p_(i,i-1), m, in the shape of `position`, (..., n).

    The gap of the first vehicle on an open road is NaN.
    """
    found = np.empty_like(position)
    found[..., 1:] = position[..., :-1] - position[..., 1:]
    found[..., 0] = (
        np.nan if ring_length_m is None else position[..., -1] + ring_length_m - position[..., 0]
    )
    return found


def distance(one: Floats, other: Floats, ring_length_m: float | None) -> Floats:
    """Return the distance between positions, m; on a ring, the shorter way."""
    if ring_length_m is None:
        return np.asarray(np.abs(one - other))
    ahead = forward(one, other, ring_length_m)
    return np.minimum(ahead, ring_length_m - ahead)


def forward(one: Floats, other: Floats, ring_length_m: float) -> Floats:
    """Return the distance from `other` forward to `one` on the ring, m, in [0, ring_length_m)."""
    return np.asarray(np.mod(one - other, ring_length_m))
