"""A beacon as a vehicle has sent it."""

from __future__ import annotations

from typing import NamedTuple

from zenvoy.bus import messages_pb2 as pb


class Sent(NamedTuple):
    """A beacon and its bytes as received, which go to the receivers unchanged."""

    beacon: pb.Beacon
    payload: bytes
