"""Which frames have come before. In real time nothing else says that a frame is repeated."""

from __future__ import annotations

from collections import deque
from typing import Final

from zenvoy.bus import messages_pb2 as pb

_REMEMBERED_NS: Final = 5_000_000_000  # a frame that is older than the newest by more is stale


class SeenFrames:
    """Frames of the last seconds, by source and arrival.

    Their contents do not matter: else a frame that was changed by a bit would count as a new one.
    """

    def __init__(self) -> None:
        self._known: set[tuple[int, int]] = set()
        self._order: deque[tuple[int, int]] = deque()  # as they came
        self._newest_ns = 0

    def are_new(self, receive: pb.Receive) -> bool:
        """Whether a receive has frames, all for the first time; if so, they are remembered."""
        rows = set(zip(receive.source, receive.arrived_ns, strict=True))
        oldest_ns = self._newest_ns - _REMEMBERED_NS
        if not rows or not rows.isdisjoint(self._known) or min(receive.arrived_ns) <= oldest_ns:
            return False
        self._known |= rows
        self._order += rows
        self._newest_ns = max(self._newest_ns, *receive.arrived_ns)
        self._forget(self._newest_ns - _REMEMBERED_NS)
        return True

    def _forget(self, until_ns: int) -> None:
        """Drop the oldest; one that came out of order stays until those before it are dropped."""
        while self._order and self._order[0][1] <= until_ns:
            self._known.discard(self._order.popleft())
