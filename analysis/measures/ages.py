"""Age of information: how old a vehicle's data about another vehicle are when it decides.

A vehicle decides at t_k + v2v_wait. The age of a link in cycle k is t_k minus the time at which the
newest frame that has arrived by then was made (after Kaul, Yates and Gruteser 2012). It is 0 if the
frame of the same cycle arrived in time, and grows by a period with each frame that is lost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table

Ints = NDArray[np.int64]


class Ages(NamedTuple):
    """Ages of all links that carried a frame, in cycles; multiply by the period to get times.

    `source` and `destination` are vehicles, (links,). `cycles` is (cycles, links), and -1 until the
    first frame of a link has arrived.
    """

    source: Ints
    destination: Ints
    cycles: NDArray[np.int32]

    def of(self, links: NDArray[np.bool_]) -> Ints:
        """Return how often each age occurred on these links, (oldest + 1,)."""
        ages = (self.cycles if links.all() else self.cycles[:, links]).ravel()
        counts = np.bincount(ages + 1)  # the first count is that of -1
        return counts[1:]

    def before_first(self, links: NDArray[np.bool_]) -> int:
        """Return the number of cycles before the first frame arrived, summed over these links."""
        return int((self.cycles[:, links] < 0).sum())

    def mean(self) -> NDArray[np.float64]:
        """Return the mean age of each link in cycles, (links,), from its first frame on."""
        known = self.cycles >= 0
        number = known.sum(axis=0)
        total = self.cycles.sum(axis=0, where=known, dtype=np.int64)
        return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def ages(frames: Table, vehicles: int, period_ns: int, wait_ns: int) -> Ages:
    """Return the ages of all links in every cycle of the frames, which are in order of time.

    `wait_ns` is the time from a cycle's start to the vehicle's decision.
    """
    number = int(frames["cycle"][-1]) + 1 if len(frames["cycle"]) else 0
    names = ("cycle", "source", "destination", "arrived_ns")
    came = frames["arrived_ns"] >= 0
    cycle, of, to, arrived_ns = (frames[name][came] for name in names)
    # A frame is known from the first cycle with arrived <= t_k + wait.
    known_from = -((wait_ns - arrived_ns) // period_ns)
    key = of.astype(np.int32) * np.int32(vehicles + 1) + to
    pairs, link = _numbered(key, (vehicles + 1) ** 2)
    in_time = known_from < number
    freshest = np.full((number, len(pairs)), -1, dtype=np.int32)
    # If several frames become known in the same cycle, the newest is assigned last and stays.
    freshest[known_from[in_time], link[in_time]] = cycle[in_time]
    np.maximum.accumulate(freshest, axis=0, out=freshest)
    age = np.arange(number, dtype=np.int32)[:, None] - freshest
    age[freshest < 0] = -1
    source, destination = np.divmod(pairs, vehicles + 1)
    return Ages(source=source, destination=destination, cycles=age)


def _numbered(key: NDArray[np.int32], size: int) -> tuple[Ints, NDArray[np.int32]]:
    """Return the keys that occur, sorted, and the index of each element of `key` in them."""
    occurs = np.zeros(size, dtype=np.bool_)
    occurs[key] = True
    found = np.flatnonzero(occurs)
    number = np.zeros(size, dtype=np.int32)
    number[found] = np.arange(len(found), dtype=np.int32)
    return found, number[key]
