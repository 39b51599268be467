"""Markov chains: a state for each link, which each frame of the sender moves by one step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.link_table import LinkTable
from zenvoy.links.sent_frames import Scene, SentFrames

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

Step = Callable[[Ints, Ints, Ints, Ints], tuple[Ints, Bools]]
"""Takes states, sources, destinations and sequence numbers; returns new states and losses, (r,)."""


class Chains:
    """Markov chains, one per ordered pair of `size` vehicles, all in state 0 at first.

    A chain moves with every frame of its sender, from the first, whether or not the receiver is in
    range. So the loss of a frame depends only on seed, link and sequence number.
    """

    def __init__(self, size: int, step: Step) -> None:
        self._step = step
        self._table = LinkTable(size, 0, 0)  # the state, and the number of the next frame

    def lost(self, source: Ints, destination: Ints, sequence: Ints) -> Bools:
        """Return which frames are lost, (r,).

        source, destination: indices from 0, (r,); sequence: (r,). Each link has at most one row.
        """
        rows = self._table.rows(source, destination)
        states, numbers = self._table.columns
        state, at = states[rows], numbers[rows]
        lost = np.zeros(len(rows), dtype=np.bool_)
        while (behind := np.flatnonzero(at <= sequence)).size:  # once, except for new links
            who, whom = source[behind], destination[behind]
            state[behind], lost[behind] = self._step(state[behind], who, whom, at[behind])
            at[behind] += 1
        states[rows], numbers[rows] = state, at
        return lost

    def judge(self, frames: SentFrames, _scene: Scene) -> Bools:
        """Return which of the frames are lost, (r,), as a loss model does."""
        return self.lost(frames.source, frames.destination, frames.sequence)
