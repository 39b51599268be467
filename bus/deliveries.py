"""Deliveries: what several vehicles receive, in columns, with each beacon once.

A shared process gets a delivery in place of a `pb.Receive` for each of its vehicles: dozens of them
hear the same beacon. Any other vehicle gets the `pb.Receive` that its part of a delivery makes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.packed import PackedCodec, encode_bytes, tag, varint

Ints = NDArray[np.int64]

_COLUMNS: Final = PackedCodec(pb.Received.DESCRIPTOR)
_HEAD: Final = FlatEncoder(pb.Receive.DESCRIPTOR, leave_out=("source", "arrived_ns", "beacon"))
_SOURCE: Final = tag(pb.Receive.SOURCE_FIELD_NUMBER, 2)
_ARRIVED: Final = tag(pb.Receive.ARRIVED_NS_FIELD_NUMBER, 2)
_BEACON: Final = pb.Receive.BEACON_FIELD_NUMBER
_RECEIVED: Final = pb.Delivery.RECEIVED_FIELD_NUMBER
_BEACON_OF_DELIVERY: Final = tag(pb.Delivery.BEACON_FIELD_NUMBER, 2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Delivery:
    """The frames that arrive at some vehicles.

    vehicle and time_ns have an entry per receiver; frames of receiver i are the rows from ends[i-1]
    to ends[i] of arrived_ns and beacon, which has indices in source and beacons.
    """

    cycle: int
    vehicle: Ints
    time_ns: Ints
    ends: Ints
    arrived_ns: Ints
    beacon: Ints
    source: Ints
    beacons: Sequence[bytes]

    def encode(self) -> bytes:
        """Return the serialized pb.Delivery."""
        received = _COLUMNS.encode(
            cycle=self.cycle,
            vehicle=self.vehicle,
            time_ns=self.time_ns,
            end=self.ends,
            arrived_ns=self.arrived_ns,
            beacon=self.beacon,
            source=self.source,
        )
        # One join of all pieces: to encode each beacon by itself copies it once more.
        pieces = [encode_bytes(_RECEIVED, received)]
        for beacon in self.beacons:
            pieces += (_BEACON_OF_DELIVERY, varint(len(beacon)), beacon)
        return b"".join(pieces)

    def of(self, receivers: Ints) -> Delivery:
        """Return the part for some receivers, by index, with the beacons that they hear."""
        counts = np.diff(self.ends, prepend=0)[receivers]
        ends = np.cumsum(counts)
        within = np.arange(counts.sum()) - np.repeat(ends - counts, counts)
        rows = np.repeat(self.ends[receivers] - counts, counts) + within
        used, beacon = _used(self.beacon[rows], len(self.beacons))
        return Delivery(
            cycle=self.cycle,
            vehicle=self.vehicle[receivers],
            time_ns=self.time_ns[receivers],
            ends=ends,
            arrived_ns=self.arrived_ns[rows],
            beacon=beacon,
            source=self.source[used],
            beacons=[self.beacons[one] for one in used.tolist()],
        )

    def receives(self) -> Iterator[tuple[int, bytes]]:
        """Yield each receiver with its serialized pb.Receive."""
        source = self.source[self.beacon].astype("<u4").tobytes()
        arrived = self.arrived_ns.astype("<i8").tobytes()
        encoded = [encode_bytes(_BEACON, one) for one in self.beacons]
        beacons = [encoded[one] for one in self.beacon.tolist()]
        start = 0
        rows = zip(self.vehicle.tolist(), self.time_ns.tolist(), self.ends.tolist(), strict=True)
        for vehicle, time_ns, end in rows:
            pieces = (
                _HEAD.encode(cycle=self.cycle, time_ns=time_ns, vehicle=vehicle),
                _SOURCE,
                varint(4 * (end - start)),
                source[4 * start : 4 * end],
                _ARRIVED,
                varint(8 * (end - start)),
                arrived[8 * start : 8 * end],
                *beacons[start:end],
            )
            yield vehicle, b"".join(pieces)
            start = end


def _used(beacon: Ints, count: int) -> tuple[Ints, Ints]:
    """Return which of `count` beacons there are, and the place of each row's beacon among them.

    np.unique does the same, but sorts all rows, which takes several times as long.
    """
    there = np.zeros(count, dtype=np.bool_)
    there[beacon] = True
    return np.flatnonzero(there), (np.cumsum(there) - 1)[beacon]


def decode(payload: bytes) -> Delivery:
    """Return the delivery in a message; raises PayloadError if its columns do not match."""
    try:
        message = pb.Delivery.FromString(payload)
        columns = _COLUMNS.decode(message.received)
    except (DecodeError, ValueError) as error:
        raise PayloadError(f"not a delivery: {error}") from error
    found = Delivery(
        cycle=int(columns["cycle"]),
        vehicle=_ints(columns["vehicle"]),
        time_ns=_ints(columns["time_ns"]),
        ends=_ints(columns["end"]),
        arrived_ns=_ints(columns["arrived_ns"]),
        beacon=_ints(columns["beacon"]),
        source=_ints(columns["source"]),
        beacons=message.beacon,
    )
    if not _matches(found):
        raise PayloadError("columns of a delivery do not match")
    return found


def _matches(found: Delivery) -> bool:
    receivers, rows = len(found.vehicle), len(found.beacon)
    if not receivers or not len(found.time_ns) == len(found.ends) == receivers:
        return False
    if len(found.arrived_ns) != rows or len(found.source) != len(found.beacons):
        return False
    counts = np.diff(found.ends, prepend=0)
    if found.ends[-1] != rows or counts.min() < 0 or np.diff(found.vehicle).min(initial=1) < 1:
        return False
    return not rows or int(found.beacon.max()) < len(found.source)


def _ints(column: NDArray[Any]) -> Ints:
    return column.astype(np.int64)
