"""A state for each link, moved one step by each frame of its sender."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

Step = Callable[[Ints, Ints, Ints, Ints], tuple[Ints, Bools]]
"""From states (r,), sources, destinations and sequence numbers: states after, and what is lost."""


class Chains:
    """Markov chains, one per ordered pair of `size` vehicles, all of them in state 0 at first.

    A chain moves with every frame of its sender, from the first, whether or not the receiver was
    in range: so what is lost is a matter of seed, link and sequence number alone.
    """

    def __init__(self, size: int, step: Step) -> None:
        self._size = size
        self._step = step
        # A row per link seen so far, in order of its code.
        self._code, self._state, self._next = (np.zeros(0, dtype=np.int64) for _ in range(3))

    def lost(self, source: Ints, destination: Ints, sequence: Ints) -> Bools:
        """Which frames are lost. All (r,): indices from 0 and sequence numbers; a row per link."""
        rows = self._rows(source * self._size + destination)
        state, at = self._state[rows], self._next[rows]
        lost = np.zeros(len(rows), dtype=np.bool_)
        while (behind := np.flatnonzero(at <= sequence)).size:  # once, but for links new in range
            who, whom = source[behind], destination[behind]
            state[behind], lost[behind] = self._step(state[behind], who, whom, at[behind])
            at[behind] += 1
        self._state[rows], self._next[rows] = state, at
        return lost

    def _rows(self, code: Ints) -> Ints:
        """Rows of these links; those not seen before are put in."""
        rows = np.searchsorted(self._code, code)
        known = rows < len(self._code)
        known[known] = self._code[rows[known]] == code[known]
        if not known.all():
            new = np.unique(code[~known])
            places = np.searchsorted(self._code, new)
            self._code = np.insert(self._code, places, new)
            self._state = np.insert(self._state, places, 0)
            self._next = np.insert(self._next, places, 0)
            rows = np.searchsorted(self._code, code)
        return rows.astype(np.int64)
