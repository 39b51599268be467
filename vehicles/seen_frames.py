"""Recognises repeated frames in real time, where nothing else tells that a frame is repeated."""

from __future__ import annotations

from collections import deque
from typing import Final

from zenvoy.bus import messages_pb2 as pb

REMEMBERED_NS: Final = 5_000_000_000  # a frame that is older than the newest by more is stale


class SeenFrames:
    """The frames of the last seconds, by source and arrival.

    Their contents do not matter: otherwise a frame with one changed bit would count as new.
    """

    def __init__(self) -> None:
        self._known: set[tuple[int, int]] = set()
        self._order: deque[tuple[int, int]] = deque()  # in order of arrival
        self._newest_ns = 0

    def are_new(self, receive: pb.Receive) -> bool:
        """Return whether a receive has frames that are all new; if so, remember them."""
        rows = set(zip(receive.source, receive.arrived_ns, strict=True))
        oldest_ns = self._newest_ns - REMEMBERED_NS
        if not rows or not rows.isdisjoint(self._known) or min(receive.arrived_ns) <= oldest_ns:
            return False
        self._known |= rows
        self._order += rows
        self._newest_ns = max(self._newest_ns, *receive.arrived_ns)
        self._forget(self._newest_ns - REMEMBERED_NS)
        return True

    def _forget(self, until_ns: int) -> None:
        """Drop the oldest frames; one out of order stays until those before it are dropped."""
        while self._order and self._order[0][1] <= until_ns:
            self._known.discard(self._order.popleft())
