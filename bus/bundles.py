"""Payloads of several vehicles in one message, as shared processes send and receive them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from google.protobuf.message import DecodeError

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.parts import MAX_PAYLOAD_BYTES

_OVERHEAD_BYTES: Final = 20  # upper bound per payload in a bundle

Parcel = tuple[int, bytes]
"""A vehicle, and a payload for it or from it."""


class Bundle:
    """Payloads of one stream to or from the vehicles of a shared process, for one message."""

    def __init__(self) -> None:
        self._parcels: list[Parcel] = []
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._parcels)

    def has_room(self, payload: bytes) -> bool:
        """Return whether the payload still fits into the message; an empty bundle has room."""
        return not self._parcels or self._bytes + _size(payload) <= MAX_PAYLOAD_BYTES

    def add(self, vehicle: int, payload: bytes) -> None:
        """Add a payload."""
        self._parcels.append((vehicle, payload))
        self._bytes += _size(payload)

    def pack(self) -> bytes:
        """Return the message, and empty the bundle."""
        parcels, self._parcels, self._bytes = self._parcels, [], 0
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


def _size(payload: bytes) -> int:
    return len(payload) + _OVERHEAD_BYTES
