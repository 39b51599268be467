"""Beacons as vehicles have sent them."""

from __future__ import annotations

from typing import NamedTuple, Self

from zenvoy.bus import messages_pb2 as pb


class Sent(NamedTuple):
    """What the channel reads of a beacon, and its bytes, which go to the receivers unchanged."""

    cycle: int
    time_ns: int
    sequence: int
    silent: bool
    payload: bytes

    @classmethod
    def of(cls, beacon: pb.Beacon, payload: bytes) -> Self:
        """Return a beacon with its bytes as received."""
        return cls(beacon.cycle, beacon.time_ns, beacon.sequence, beacon.silent, payload)
