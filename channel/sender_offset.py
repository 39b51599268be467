"""An offset that a sender keeps for a number of messages.

C-V2X mode 4 picks a resource in its selection window and holds it while a counter, drawn from 5 to
15, counts down with the messages sent. Then it keeps the resource with a given probability, or
picks a new one (3GPP TS 36.321, sections 5.14.1.1 and 5.4.1, sl-ReselectAfter and
probResourceKeep).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Draws, Purpose, Seeds
from zenvoy.links.sent_frames import SentFrames
from zenvoy.scenarios import SenderOffset

Ints = NDArray[np.int64]


class SenderOffsets:
    """The offsets of senders; they depend only on seed, sender and sequence number.

    Sections with different `number` have independent draws.
    """

    def __init__(self, settings: SenderOffset, seeds: Seeds, number: int = 0) -> None:
        size = seeds.vehicles
        self._settings, self._size = settings, size
        self._offsets, self._keeps = (
            Draws(seeds, purpose) for purpose in (Purpose.SENDER_OFFSET, Purpose.SENDER_KEEPS)
        )
        self._number = number
        self._max_ns = round(settings.max_ms * 1e6)
        self._offset_ns, self._picks, self._next, self._left = (
            np.zeros(size, dtype=np.int64) for _ in range(4)
        )

    @property
    def used(self) -> bool:
        """Whether offsets are not always 0."""
        return self._max_ns > 0

    def of(self, frames: SentFrames) -> Ints:
        """Return the offsets of these frames, ns, (r,).

        The sequence numbers of a sender must not fall from call to call.
        """
        if self._max_ns == 0:
            return np.zeros(len(frames.source), dtype=np.int64)
        newest = np.full(self._size, -1)
        newest[frames.source] = frames.sequence
        while (behind := np.flatnonzero(self._next <= newest)).size:  # usually once
            self._step(behind)
        return self._offset_ns[frames.source]

    def _step(self, sender: Ints) -> None:
        """Advance each sender by one frame."""
        self._next[sender] += 1
        ended = sender[self._left[sender] == 0]
        if ended.size:
            self._pick(ended)
        self._left[sender] -= 1

    def _pick(self, sender: Ints) -> None:
        settings, pick = self._settings, self._picks[sender]
        keys = (sender, pick, self._number)
        place, span = self._offsets.of_vehicles(*keys)
        keep, _ = self._keeps.of_vehicles(*keys)
        moves = (pick == 0) | (keep >= settings.keep)
        new_ns = np.floor(place * self._max_ns).astype(np.int64)
        self._offset_ns[sender] = np.where(moves, new_ns, self._offset_ns[sender])
        spans = 1 + settings.to_messages - settings.from_messages
        self._left[sender] = settings.from_messages + np.floor(span * spans).astype(np.int64)
        self._picks[sender] += 1
