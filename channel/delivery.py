"""Frames on the air, and their delivery in order of arrival."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.packed import encode_bytes, tag, varint
from zenvoy.bus.topics import RECEIVE

Ints = NDArray[np.int64]

_HEAD: Final = FlatEncoder(pb.Receive.DESCRIPTOR, leave_out=("source", "arrived_ns", "beacon"))
_SOURCE: Final = tag(pb.Receive.SOURCE_FIELD_NUMBER, 2)
_ARRIVED: Final = tag(pb.Receive.ARRIVED_NS_FIELD_NUMBER, 2)
_BEACON: Final = pb.Receive.BEACON_FIELD_NUMBER


class Air:
    """The frames in flight to a fleet of `size` vehicles.

    A receive is assembled from encoded pieces: each beacon is encoded once, not once for each
    receiver, and the columns are slices of arrays.
    """

    def __init__(self, size: int) -> None:
        self._vehicles = range(1, size + 1)
        # Encoded beacons by number of the frame, from the oldest that is still in flight.
        self._beacons = np.zeros(0, dtype=np.object_)
        self._first_number = 0
        # A row per frame and receiver: number and source of the frame, destination, arrival (ns).
        self._number, self._source, self._destination, self._arrived_ns = (
            np.zeros(0, dtype=np.int64) for _ in range(4)
        )

    def send(
        self, payloads: Mapping[int, bytes], source: Ints, destination: Ints, arrived_ns: Ints
    ) -> None:
        """Put the frames of a cycle on the air; payloads: serialized beacons by sender.

        The arrays have a row per frame and receiver: the indices of sender and receiver, from 0,
        and the time of arrival, ns (-1: never).
        """
        first = self._first_number + len(self._beacons)
        senders = sorted(payloads)  # the numbers of frames must not depend on the order of arrival
        encoded = np.empty(len(senders), dtype=np.object_)
        encoded[:] = [encode_bytes(_BEACON, payloads[vehicle]) for vehicle in senders]
        self._beacons = np.concatenate([self._beacons, encoded])
        comes = arrived_ns >= 0
        numbers = np.zeros(len(self._vehicles) + 1, dtype=np.int64)
        numbers[senders] = first + np.arange(len(senders))
        vehicle = source[comes] + 1
        self._number = np.concatenate([self._number, numbers[vehicle]])
        self._source = np.concatenate([self._source, vehicle])
        self._destination = np.concatenate([self._destination, destination[comes] + 1])
        self._arrived_ns = np.concatenate([self._arrived_ns, arrived_ns[comes]])

    def deliver(self, cycle: int, until_ns: int, vehicles: Sequence[int]) -> list[Envelope]:
        """Return a receive for each of `vehicles`, in order, with what has arrived by `until_ns`.

        What arrives at others is lost: nobody listens there.
        """
        due = self._due(until_ns)
        heard = due
        if len(vehicles) < len(self._vehicles):
            heard = due[np.isin(self._destination[due], vehicles)]
        receives = self._receives(heard, vehicles, cycle, until_ns)
        self._forget(due)
        return receives

    @property
    def next_ns(self) -> int | None:
        """The time of the next arrival; None if no frame is in flight."""
        return int(self._arrived_ns.min()) if len(self._arrived_ns) else None

    def batch(self, cycle: int, until_ns: int) -> tuple[int, list[Envelope]]:
        """Return the receives with all frames that arrive by `until_ns`, and when the last arrives.

        Only vehicles to which a frame arrives get a receive; its time is that of its last frame.
        The frames stay in flight until `landed`. Raises ValueError if no frame arrives.
        """
        due = self._due(until_ns)
        at_ns = int(self._arrived_ns[due].max())
        vehicles = np.unique(self._destination[due]).tolist()
        return at_ns, self._receives(due, vehicles, cycle, None)

    def landed(self, until_ns: int) -> None:
        """Forget the frames that have arrived by `until_ns`."""
        self._forget(self._due(until_ns))

    def _due(self, until_ns: int) -> Ints:
        """Return the rows of frames that arrive by `until_ns`, by destination, then arrival."""
        due = np.flatnonzero(self._arrived_ns <= until_ns)
        keys = (self._number[due], self._arrived_ns[due], self._destination[due])
        return due[np.lexsort(keys)]

    def _receives(
        self, due: Ints, vehicles: Sequence[int], cycle: int, time_ns: int | None
    ) -> list[Envelope]:
        """Return a receive for each of `vehicles`, in order, with its own of the rows due.

        Its time is `time_ns`, or, if that is None, the arrival of its last frame.
        """
        bounds = np.searchsorted(self._destination[due], [*vehicles, len(self._vehicles) + 1])
        source = self._source[due].astype("<u4").tobytes()
        arrived_ns = self._arrived_ns[due]
        arrived = arrived_ns.astype("<i8").tobytes()
        beacons = self._beacons[self._number[due] - self._first_number].tolist()
        receives = []
        spans = zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True)
        for vehicle, (start, end) in zip(vehicles, spans, strict=True):
            pieces = (
                _HEAD.encode(
                    cycle=cycle,
                    time_ns=arrived_ns[end - 1] if time_ns is None else time_ns,
                    vehicle=vehicle,
                ),
                _SOURCE,
                varint(4 * (end - start)),
                source[4 * start : 4 * end],
                _ARRIVED,
                varint(8 * (end - start)),
                arrived[8 * start : 8 * end],
                *beacons[start:end],
            )
            receives.append(Envelope(RECEIVE, vehicle, b"".join(pieces)))
        return receives

    def _forget(self, landed: Ints) -> None:
        """Drop the rows that were delivered, and the beacons that no row needs any more."""
        flies = np.ones(len(self._number), dtype=np.bool_)
        flies[landed] = False
        self._number, self._source = self._number[flies], self._source[flies]
        self._destination, self._arrived_ns = self._destination[flies], self._arrived_ns[flies]
        end = self._first_number + len(self._beacons)
        oldest = int(self._number.min(initial=end))
        self._beacons = self._beacons[oldest - self._first_number :]
        self._first_number = oldest
