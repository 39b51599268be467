"""Pairs of vehicles that are in range of each other."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.distance import distance

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class Pairs(NamedTuple):
    """Ordered pairs of vehicles, sorted by source, then destination, (r,).

    Source and destination are indices from 0; distance is in m along the road.
    """

    source: Ints
    destination: Ints
    distance: Floats
    in_range: NDArray[np.bool_]

    def only(self, chosen: NDArray[np.bool_]) -> Pairs:
        """Return some of the pairs."""
        return Pairs._make(column[chosen] for column in self)


def pairs(position: Floats, range_m: float, ring_length_m: float | None) -> Pairs:
    """Return every ordered pair within `range_m`, and every pair of neighbours, in range or not.

    position (n,): m along the road, not wrapped. A neighbour out of range has a row because it
    explains what a controller misses. Other vehicles out of range have none, so that the cost
    grows only with the vehicles in range.
    """
    n = len(position)
    if ring_length_m is not None and 2 * range_m >= ring_length_m:
        source, destination = _everyone(n)
    else:
        source, destination = _near(position, range_m, ring_length_m)
    apart = distance(position[source], position[destination], ring_length_m)
    return Pairs(source, destination, apart, apart <= range_m)


@lru_cache(maxsize=4)
def _everyone(n: int) -> tuple[Ints, Ints]:
    """Return every ordered pair of n vehicles."""
    source, destination = (index.ravel() for index in np.indices((n, n), dtype=np.int64))
    keep = source != destination
    return source[keep], destination[keep]


def _near(position: Floats, range_m: float, ring_length_m: float | None) -> tuple[Ints, Ints]:
    """Return the pairs within range, found by a sorted search, and the pairs of neighbours.

    Vehicles are sorted by position on a line, and the range of each vehicle is a slice of that
    line. A ring is unrolled three times, so that no slice crosses the seam.
    """
    n = len(position)
    place = position if ring_length_m is None else np.mod(position, ring_length_m)
    order = np.argsort(place, kind="stable").astype(np.int64)
    line, who = place[order], order
    if ring_length_m is not None:
        line = np.concatenate([line - ring_length_m, line, line + ring_length_m])
        who = np.tile(who, 3)
    # Slightly wider than the range, so that rounding in the search loses no pair; `pairs` decides.
    reach = range_m + 1e-6
    low = np.searchsorted(line, place - reach, side="left")
    count = np.searchsorted(line, place + reach, side="right") - low
    # A row per vehicle and member of its slice, itself included; `within` is the index there.
    source = np.repeat(np.arange(n, dtype=np.int64), count)
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    destination = who[np.repeat(low, count) + within]
    # Neighbours in both directions. The last vehicle on an open road gets itself, dropped below.
    i = np.arange(n, dtype=np.int64)
    beside = (i + 1) % n if ring_length_m is not None else np.minimum(i + 1, n - 1)
    code = np.concatenate([source * n + destination, i * n + beside, beside * n + i])
    code.sort()  # sort and compare: np.unique takes ten times as long
    source, destination = np.divmod(code[np.diff(code, prepend=-1) != 0], n)
    keep = source != destination
    return source[keep], destination[keep]
