"""Frames on the air, and their delivery in order of arrival."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.agent import Envelope
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.topics import RECEIVE
from zenvoy.bus.vehicle_processes import VehicleProcess

Ints = NDArray[np.int64]


class Air:
    """The frames in flight to a fleet of `size` vehicles.

    `shared` are the processes that run several vehicles: each gets one delivery for all of them.
    """

    def __init__(self, size: int, shared: Sequence[VehicleProcess] = ()) -> None:
        self._vehicles = range(1, size + 1)
        self._shared = shared
        self._process = np.full(size + 1, -1)  # by vehicle: its place among them
        for number, process in enumerate(shared):
            self._process[[*process.vehicles]] = number
        # Beacons and their senders by number of the frame, from the oldest that is in flight.
        self._beacons = np.zeros(0, dtype=np.object_)
        self._senders = np.zeros(0, dtype=np.int64)
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
        beacons = np.empty(len(senders), dtype=np.object_)
        beacons[:] = [payloads[vehicle] for vehicle in senders]
        self._beacons = np.concatenate([self._beacons, beacons])
        self._senders = np.concatenate([self._senders, np.array(senders, dtype=np.int64)])
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

        Those of a shared process are one message. The time of a receive is `time_ns`, or, if that
        is None, the arrival of its last frame.
        """
        ends = np.searchsorted(self._destination[due], vehicles, side="right")
        arrived_ns, beacon = self._arrived_ns[due], self._number[due] - self._first_number
        receivers = np.array(vehicles, dtype=np.int64)  # there may be none
        times_ns = arrived_ns[ends - 1] if time_ns is None else np.full(len(vehicles), time_ns)
        whole = Delivery(
            cycle=cycle,
            vehicle=receivers,
            time_ns=times_ns,
            ends=ends,
            arrived_ns=arrived_ns,
            beacon=beacon,
            source=self._senders,
            beacons=self._beacons.tolist(),
        )
        if not self._shared:
            return [Envelope(RECEIVE, vehicle, one) for vehicle, one in whole.receives()]
        process = self._process[receivers]
        found = []
        for number in np.unique(process[process >= 0]).tolist():
            rows = np.flatnonzero(process == number)
            first = self._shared[number].vehicles[0]
            part = whole.of(rows)
            found.append(Envelope(RECEIVE, first, part.encode(), bundled=True))
        alone = whole.of(np.flatnonzero(process < 0))
        return found + [Envelope(RECEIVE, vehicle, one) for vehicle, one in alone.receives()]

    def _forget(self, landed: Ints) -> None:
        """Drop the rows that were delivered, and the beacons that no row needs any more."""
        flies = np.ones(len(self._number), dtype=np.bool_)
        flies[landed] = False
        self._number, self._source = self._number[flies], self._source[flies]
        self._destination, self._arrived_ns = self._destination[flies], self._arrived_ns[flies]
        end = self._first_number + len(self._beacons)
        oldest = int(self._number.min(initial=end))
        self._beacons = self._beacons[oldest - self._first_number :]
        self._senders = self._senders[oldest - self._first_number :]
        self._first_number = oldest
