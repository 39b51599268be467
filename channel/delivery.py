"""Frames on the air, and their delivery in order of arrival."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.agent import Envelope
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.topics import RECEIVE
from zenvoy.bus.vehicle_processes import VehicleProcess

Ints = NDArray[np.int64]

_LARGEST_KEY: Final = 2**62


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
        # A row per frame and receiver, by arrival (ns), then number of the frame.
        self._number, self._arrived_ns = np.zeros((2, 0), dtype=np.int64)
        # In few bytes, because numpy sorts those four times as fast.
        self._destination = np.zeros(0, dtype=np.min_scalar_type(size))

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
        number = np.concatenate([self._number, numbers[source[comes] + 1]])
        arrived = np.concatenate([self._arrived_ns, arrived_ns[comes]])
        order = _by_arrival(arrived, number)
        self._number, self._arrived_ns = number[order], arrived[order]
        reaches = (destination[comes] + 1).astype(self._destination.dtype)
        self._destination = np.concatenate([self._destination, reaches])[order]

    def deliver(self, cycle: int, until_ns: int, vehicles: Sequence[int]) -> list[Envelope]:
        """Return a receive for each of `vehicles`, in order, with what has arrived by `until_ns`.

        What arrives at others is lost: nobody listens there.
        """
        due = self._due(until_ns)
        heard = due
        if len(vehicles) < len(self._vehicles):
            heard = due[np.isin(self._destination[due], vehicles)]
        receives = self._receives(heard, vehicles, cycle, until_ns)
        self._forget(until_ns)
        return receives

    @property
    def next_ns(self) -> int | None:
        """The time of the next arrival; None if no frame is in flight."""
        return int(self._arrived_ns[0]) if len(self._arrived_ns) else None

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
        self._forget(until_ns)

    def _due(self, until_ns: int) -> Ints:
        """Return the rows of frames that arrive by `until_ns`, by destination, then arrival."""
        return np.argsort(self._destination[: self._arrived_by(until_ns)], kind="stable")

    def _arrived_by(self, until_ns: int) -> int:
        """Return how many frames arrive by `until_ns`; they are the first rows."""
        return int(np.searchsorted(self._arrived_ns, until_ns, side="right"))

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

    def _forget(self, until_ns: int) -> None:
        """Drop the rows that have arrived, and the beacons that no row needs any more."""
        left = self._arrived_by(until_ns)
        self._number, self._destination = self._number[left:], self._destination[left:]
        self._arrived_ns = self._arrived_ns[left:]
        end = self._first_number + len(self._beacons)
        oldest = int(self._number.min(initial=end))
        self._beacons = self._beacons[oldest - self._first_number :]
        self._senders = self._senders[oldest - self._first_number :]
        self._first_number = oldest


def _by_arrival(arrived_ns: Ints, number: Ints) -> Ints:
    """Return the order of rows by arrival, then number."""
    if not len(number):
        return np.zeros(0, dtype=np.int64)
    since_ns, after = arrived_ns - arrived_ns.min(), number - number.min()
    numbers = int(after.max()) + 1
    if (int(since_ns.max()) + 1) * numbers > _LARGEST_KEY:
        return np.lexsort((number, arrived_ns))
    return np.argsort(since_ns * numbers + after)  # takes half the time of np.lexsort
