"""Age of information: how old what a vehicle knows of another is when it decides.

The age of a link in cycle k is t_k less the time at which the freshest frame was made that has
arrived by t_k + v2v_wait, when the vehicle decides (after Kaul, Yates and Gruteser 2012). It is 0
where the frame of this very cycle came in time, and grows by a period with each frame that is lost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table

Ints = NDArray[np.int64]


class Ages(NamedTuple):
    """Ages of all links that carried a frame, in cycles; multiply by the period.

    `source` and `destination` are vehicles, (links,); `cycles` is (cycles, links), -1 before the
    first frame of a link has arrived.
    """

    source: Ints
    destination: Ints
    cycles: NDArray[np.int32]

    def of(self, links: NDArray[np.bool_]) -> Ints:
        """How many ages of each size there were on these links, (oldest + 1,)."""
        ages = (self.cycles if links.all() else self.cycles[:, links]).ravel()
        counts = np.bincount(ages + 1)  # -1 comes first
        return counts[1:]

    def unheard(self, links: NDArray[np.bool_]) -> int:
        """In how many cycles nothing had been heard yet, summed over these links."""
        return int((self.cycles[:, links] < 0).sum())

    def mean(self) -> NDArray[np.float64]:
        """Mean age of each link in cycles, (links,), from its first frame on."""
        heard = self.cycles >= 0
        number = heard.sum(axis=0)
        total = self.cycles.sum(axis=0, where=heard, dtype=np.int64)
        return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def ages(frames: Table, vehicles: int, period_ns: int, wait_ns: int) -> Ages:
    """Ages in every cycle of the frames, which are in order of time; see `Ages`.

    `wait_ns` is how long after a cycle's start a vehicle decides.
    """
    number = int(frames["cycle"][-1]) + 1 if len(frames["cycle"]) else 0
    names = ("cycle", "source", "destination", "arrived_ns")
    came = frames["arrived_ns"] >= 0
    cycle, of, to, arrived_ns = (frames[name][came] for name in names)
    # The first cycle whose decision it is in time for: arrived <= t_k + wait.
    known_from = -((wait_ns - arrived_ns) // period_ns)
    key = of.astype(np.int32) * np.int32(vehicles + 1) + to
    pairs, link = _numbered(key, (vehicles + 1) ** 2)
    in_time = known_from < number
    freshest = np.full((number, len(pairs)), -1, dtype=np.int32)
    # Of frames that come in the same cycle, the last to be assigned is the freshest.
    freshest[known_from[in_time], link[in_time]] = cycle[in_time]
    np.maximum.accumulate(freshest, axis=0, out=freshest)
    age = np.arange(number, dtype=np.int32)[:, None] - freshest
    age[freshest < 0] = -1
    source, destination = np.divmod(pairs, vehicles + 1)
    return Ages(source=source, destination=destination, cycles=age)


def _numbered(key: NDArray[np.int32], size: int) -> tuple[Ints, NDArray[np.int32]]:
    """The keys that occur, sorted, and for each element of `key` which of them it is."""
    occurs = np.zeros(size, dtype=np.bool_)
    occurs[key] = True
    found = np.flatnonzero(occurs)
    number = np.zeros(size, dtype=np.int32)
    number[found] = np.arange(len(found), dtype=np.int32)
    return found, number[key]
