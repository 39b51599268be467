"""Who is in range of whom."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.distance import distance

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class Pairs(NamedTuple):
    """Ordered pairs of vehicles, by source, then destination, (r,).

    The ends are indices from 0, and distance (m) is along the road.
    """

    source: Ints
    destination: Ints
    distance: Floats
    in_range: NDArray[np.bool_]

    def only(self, chosen: NDArray[np.bool_]) -> Pairs:
        """Return some of the pairs."""
        return Pairs._make(column[chosen] for column in self)


def pairs(position: Floats, range_m: float, ring_length_m: float | None) -> Pairs:
    """Return every ordered pair within `range_m`, and each vehicle with its neighbours in any case.

    `position` (n,): m along the road, not wrapped. The cost grows with the vehicles in range: a
    neighbour out of range is worth a row, for it explains what a controller misses; a vehicle far
    away is not.
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
    """Every ordered pair of n vehicles."""
    source, destination = (index.ravel() for index in np.indices((n, n), dtype=np.int64))
    keep = source != destination
    return source[keep], destination[keep]


def _near(position: Floats, range_m: float, ring_length_m: float | None) -> tuple[Ints, Ints]:
    """Pairs within range by a sorted search, and the neighbours in the row.

    Vehicles are sorted by place on a line; each one's range is a slice of that line. The ring is
    unrolled: the line holds it three times, so that no slice goes over the seam.
    """
    n = len(position)
    place = position if ring_length_m is None else np.mod(position, ring_length_m)
    order = np.argsort(place, kind="stable").astype(np.int64)
    line, who = place[order], order
    if ring_length_m is not None:
        line = np.concatenate([line - ring_length_m, line, line + ring_length_m])
        who = np.tile(who, 3)
    # A hair wider than the range, so that rounding in the search loses nobody; `pairs` decides.
    reach = range_m + 1e-6
    low = np.searchsorted(line, place - reach, side="left")
    count = np.searchsorted(line, place + reach, side="right") - low
    # A row per vehicle and member of its slice, itself among them; `within` counts in the slice.
    source = np.repeat(np.arange(n, dtype=np.int64), count)
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    destination = who[np.repeat(low, count) + within]
    # Neighbours in the row, both ways. The last of the open road gets itself, dropped below.
    i = np.arange(n, dtype=np.int64)
    beside = (i + 1) % n if ring_length_m is not None else np.minimum(i + 1, n - 1)
    code = np.concatenate([source * n + destination, i * n + beside, beside * n + i])
    code.sort()  # then unique: numpy's own takes ten times as long
    source, destination = np.divmod(code[np.diff(code, prepend=-1) != 0], n)
    keep = source != destination
    return source[keep], destination[keep]
