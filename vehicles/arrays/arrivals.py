"""Frames that arrive in real time at vehicles that run as arrays, at any time and in any order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.bus.checks import is_of
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.refusals import ABSURD, FOREIGN
from zenvoy.vehicles.arrays.heard import Frames, Hearing, refused
from zenvoy.vehicles.arrays.rows import Ints


class Arrivals(NamedTuple):
    """The frames of a delivery, at `time_ns` of simulation time, and why they are refused, or None.

    receiver, source and arrived_ns have an entry per frame: the index of the receiver, the number
    of the sender, and the time of arrival. `identity` makes one number of these. It wraps around
    after minutes at the earliest, and frames are remembered for seconds.
    """

    cycle: int
    time_ns: int
    frames: Frames
    receiver: Ints
    source: Ints
    arrived_ns: Ints
    identity: Ints

    @property
    def fault(self) -> str | None:
        """Why the frames are refused, or None."""
        return self.frames.fault


class Arriving:
    """Reads deliveries to some vehicles of a fleet of `size`."""

    def __init__(self, hearing: Hearing, vehicles: Sequence[int], size: int) -> None:
        self._hearing, self._vehicles, self._size = hearing, np.array(vehicles), size

    def read(self, delivery: Delivery) -> Arrivals:
        """Return the frames of a delivery; a fault says why they are all refused."""
        vehicle, counts = delivery.vehicle, np.diff(delivery.ends, prepend=0)
        at = np.minimum(np.searchsorted(self._vehicles, vehicle), len(self._vehicles) - 1)
        receiver = np.repeat(at, counts)
        source, arrived_ns = delivery.source[delivery.beacon], delivery.arrived_ns
        time_ns = int(delivery.time_ns.max())
        if (self._vehicles[at] != vehicle).any():
            frames = refused(delivery.cycle, FOREIGN)
        elif not self._makes_sense(delivery, counts, source, self._vehicles[receiver]):
            frames = refused(delivery.cycle, ABSURD)
        else:
            frames = self._hearing.frames(delivery, receiver, time_ns)
        link = receiver * (self._size + 1) + source
        identity = arrived_ns * (len(self._vehicles) * (self._size + 1)) + link
        return Arrivals(delivery.cycle, time_ns, frames, receiver, source, arrived_ns, identity)

    def _makes_sense(
        self, delivery: Delivery, counts: Ints, source: Ints, destination: Ints
    ) -> bool:
        """Return whether all frames are of others, and the last to a receiver gives its time."""
        if not counts.all():
            return False
        last_ns = np.maximum.reduceat(delivery.arrived_ns, delivery.ends - counts)
        if not np.array_equal(last_ns, delivery.time_ns):
            return False
        if (source < 1).any() or (source > self._size).any() or (source == destination).any():
            return False
        pairs = zip(delivery.beacons, delivery.source.tolist(), strict=True)
        return all(is_of(beacon, number) for beacon, number in pairs)


def by_receiver(
    received: Sequence[tuple[Arrivals, int]], count: int
) -> tuple[Ints, dict[str, Ints]]:
    """Return the frames to `count` vehicles, one vehicle after the other, as in `pb.Timing`.

    These are how many frames each vehicle and those before it have, (count,), and columns by name.
    received: deliveries, in order, and when they came (ns of simulation time).
    """
    each = [one for one, _ in received]
    came_ns = [np.full(len(one.source), came_ns) for one, came_ns in received]
    receiver = _joined([one.receiver for one in each])
    order = np.argsort(receiver, kind="stable")
    columns = {
        "source": _joined([one.source for one in each])[order],
        "arrived_ns": _joined([one.arrived_ns for one in each])[order],
        "came_ns": _joined(came_ns)[order],
    }
    return np.cumsum(np.bincount(receiver, minlength=count)), columns


def _joined(columns: Sequence[Ints]) -> Ints:
    return np.concatenate([np.zeros(0, dtype=np.int64), *columns])
