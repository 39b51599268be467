"""Which frames have come before, for a radio that nobody counts cycles for."""

from __future__ import annotations

from typing import Final

from zenvoy.bus import messages_pb2 as pb

_REMEMBERED_NS: Final = 5_000_000_000  # a frame that is older than the newest by more is stale


class Frames:
    """Frames of the last seconds, by source and arrival.

    What they say is left out: else a frame counts anew that was changed by a bit.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[int, int], None] = {}  # in the order in which they came
        self._newest_ns = 0

    def are_new(self, receive: pb.Receive) -> bool:
        """Whether a receive has frames, all for the first time; if so, they are remembered."""
        rows = dict.fromkeys(zip(receive.source, receive.arrived_ns, strict=True))
        oldest_ns = self._newest_ns - _REMEMBERED_NS
        if not rows or any(row in self._known or row[1] <= oldest_ns for row in rows):
            return False
        self._known |= rows
        self._newest_ns = max([self._newest_ns, *receive.arrived_ns])
        self._forget(self._newest_ns - _REMEMBERED_NS)
        return True

    def _forget(self, until_ns: int) -> None:
        """Drop the oldest; one that came out of order stays until those before it are dropped."""
        while self._known and (oldest := next(iter(self._known)))[1] <= until_ns:
            del self._known[oldest]
