"""Gaps and distances along the road, on the ring and on the open road.

A gap goes from a vehicle forward to the one that it follows in the row, and knows laps: on the
ring the gaps sum up to its length. A distance is the shorter way between any two, whoever follows
whom. Positions are along the road, m, not wrapped; `ring_length_m` None: the open road.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def gaps(position: Floats, ring_length_m: float | None) -> Floats:
    """Return p_(i,i-1), m, of the shape of `position`, (..., n).

    The gap of the first vehicle is NaN on the open road.
    """
    found = np.empty_like(position)
    found[..., 1:] = position[..., :-1] - position[..., 1:]
    found[..., 0] = (
        np.nan if ring_length_m is None else position[..., -1] + ring_length_m - position[..., 0]
    )
    return found


def distance(one: Floats, other: Floats, ring_length_m: float | None) -> Floats:
    """Return how far two positions are apart, m; on the ring, by the shorter way."""
    if ring_length_m is None:
        return np.asarray(np.abs(one - other))
    ahead = forward(one, other, ring_length_m)
    return np.minimum(ahead, ring_length_m - ahead)


def forward(one: Floats, other: Floats, ring_length_m: float) -> Floats:
    """Return the way from `other` forward to `one` on the ring, m, in [0, ring_length_m)."""
    return np.asarray(np.mod(one - other, ring_length_m))
