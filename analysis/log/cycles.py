"""Keeps track of the cycles of the messages in a log, and of which of them can be used.

Row k of a table is cycle k. A message that comes twice, too early or after a gap would break that.
It is left out and reported.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

# The cycle is the first field of its message. It has a fixed width, and is absent where it is 0.
_CYCLE: Final = struct.Struct("<BI")
_TAG: Final = 0x0D
_MAX_NAMED: Final = 3  # stretches that a sentence lists

Stretch = tuple[int, int]
"""First and last of consecutive cycles."""


def cycle_of(payload: bytes | memoryview) -> int:
    """Return the cycle of a message, for topics with one message per cycle."""
    if len(payload) < _CYCLE.size:
        return 0
    tag, cycle = _CYCLE.unpack_from(payload)
    return int(cycle) if tag == _TAG else 0


class Cycles:
    """The cycles of one topic in the order of the log; the run ends with cycle `last`."""

    def __init__(self, last: int = 0xFFFFFFFF) -> None:
        self._last = last
        self._found = array("I")
        self.kept = 0
        """How many cycles can be used: 0 to `kept` - 1."""

    def take(self, payload: bytes | memoryview) -> bool:
        """Note a message, and return whether it belongs to the cycle that comes next."""
        cycle = cycle_of(payload)
        self._found.append(cycle)
        is_next = cycle == self.kept and cycle <= self._last
        self.kept += is_next
        return is_next

    def missing(self) -> list[Stretch]:
        """Return the cycles before the last one that have no message."""
        found = self._sorted()
        if not found.size:
            return []
        edges = np.concatenate(([-1], found))
        at = np.flatnonzero(np.diff(edges) > 1)
        return [(int(edges[i]) + 1, int(edges[i + 1]) - 1) for i in at]

    def twice(self) -> list[Stretch]:
        """Return the cycles that have more than one message."""
        found, counts = np.unique(self._array(), return_counts=True)
        return list(stretches(found[counts > 1].tolist()))

    @property
    def last(self) -> int:
        """The highest cycle of any message; 0 where there is none."""
        return max(self._found, default=0)

    @property
    def beyond(self) -> int:
        """The highest cycle if it is after the end of the run, else 0."""
        return self.last if self.last > self._last else 0

    @property
    def ordered(self) -> bool:
        """Whether the cycles never decrease from one message to the next."""
        found = self._array()
        return bool((found[1:] >= found[:-1]).all())

    def _array(self) -> NDArray[np.int64]:
        return np.frombuffer(self._found, np.uint32).astype(np.int64)

    def _sorted(self) -> NDArray[np.int64]:
        return np.unique(self._array())


def stretches(cycles: Sequence[int]) -> Iterator[Stretch]:
    """Yield the stretches of consecutive numbers in an ascending sequence."""
    first = last = None
    for cycle in cycles:
        if last is not None and first is not None and cycle != last + 1:
            yield first, last
            first = cycle
        first = cycle if first is None else first
        last = cycle
    if first is not None and last is not None:
        yield first, last


def union(parts: Iterable[Sequence[Stretch]]) -> list[Stretch]:
    """Return the stretches of all cycles that are in at least one of the parts."""
    joined: list[Stretch] = []
    for first, last in sorted(stretch for part in parts for stretch in part):
        if joined and first <= joined[-1][1] + 1:
            joined[-1] = joined[-1][0], max(last, joined[-1][1])
        else:
            joined.append((first, last))
    return joined


def named(found: Sequence[Stretch]) -> str:
    """Return stretches in words: "cycles 4 to 7, 9 and 2 more stretches"."""
    words = [f"{a}" if a == b else f"{a} to {b}" for a, b in found[:_MAX_NAMED]]
    more = len(found) - _MAX_NAMED
    if more > 0:
        words.append(f"{more} more stretch{'es' if more > 1 else ''}")
    single = len(found) == 1 and found[0][0] == found[0][1]
    text = words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
    return f"cycle{'' if single else 's'} {text}"
