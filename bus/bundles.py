"""Payloads of several vehicles in one message, as shared processes send and receive them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from google.protobuf.message import DecodeError

from zenvoy.bus import deliveries
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.topics import RECEIVE, Topic

Parcel = tuple[int, bytes]
"""A vehicle, and a payload for it or from it."""


class Bundle:
    """Payloads of one stream to or from the vehicles of a shared process, for one message."""

    def __init__(self) -> None:
        self._parcels: list[Parcel] = []

    def __len__(self) -> int:
        return len(self._parcels)

    def add(self, vehicle: int, payload: bytes) -> None:
        """Add a payload."""
        self._parcels.append((vehicle, payload))

    def pack(self) -> bytes:
        """Return the message, and empty the bundle."""
        parcels, self._parcels = self._parcels, []
        return pack(parcels)


def pack(parcels: Iterable[Parcel]) -> bytes:
    """Return one message with at least one payload of a stream."""
    vehicles, payloads = zip(*parcels, strict=True)
    return pb.Bundle(vehicle=vehicles, payload=payloads).SerializeToString()


def unpack(bundle: bytes) -> list[Parcel]:
    """Return the payloads in a message of `pack`; raises PayloadError if columns do not match."""
    try:
        message = pb.Bundle.FromString(bundle)
    except DecodeError as error:
        raise PayloadError(f"not a bundle: {error}") from error
    if len(message.vehicle) != len(message.payload):
        raise PayloadError(f"{len(message.vehicle)} vehicles, {len(message.payload)} payloads")
    return list(zip(message.vehicle, message.payload, strict=True))


def parcels_in(topic: Topic[Any], payload: bytes) -> list[Parcel]:
    """Return the payloads in one message for all vehicles of a process; raises PayloadError."""
    return list(deliveries.decode(payload).receives()) if topic is RECEIVE else unpack(payload)
