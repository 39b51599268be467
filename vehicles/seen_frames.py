"""Recognises repeated frames in real time, where nothing else tells that a frame is repeated."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Sequence
from typing import Final

_REMEMBERED_NS: Final = 5_000_000_000  # a frame that is older than the newest by more is stale


class SeenFrames:
    """The frames of the last seconds, each known by what tells it from others, and its arrival.

    Their contents do not matter: otherwise a frame with one changed bit would count as new.
    """

    def __init__(self) -> None:
        self._known: set[Hashable] = set()
        self._order: deque[tuple[Hashable, int]] = deque()  # in order of arrival
        self._newest_ns = 0

    def are_new(self, frames: Sequence[Hashable], arrived_ns: Sequence[int]) -> bool:
        """Return whether there are frames, and all are new; if so, remember them."""
        oldest_ns = self._newest_ns - _REMEMBERED_NS
        if not frames or not self._known.isdisjoint(frames) or min(arrived_ns) <= oldest_ns:
            return False
        self._known.update(frames)
        self._order += zip(frames, arrived_ns, strict=True)
        self._newest_ns = max(self._newest_ns, *arrived_ns)
        self._forget(self._newest_ns - _REMEMBERED_NS)
        return True

    def _forget(self, until_ns: int) -> None:
        """Drop the oldest frames; one out of order stays until those before it are dropped."""
        while self._order and self._order[0][1] <= until_ns:
            self._known.discard(self._order.popleft()[0])
