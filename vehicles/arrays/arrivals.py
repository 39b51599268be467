"""Frames that arrive in real time at vehicles that run as arrays, at any time and in any order."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.checks import is_of
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.packed import tag, varint
from zenvoy.bus.refusals import ABSURD, FOREIGN
from zenvoy.vehicles.arrays.heard import Frames, Hearing, refused
from zenvoy.vehicles.arrays.rows import Ints
from zenvoy.vehicles.seen_frames import REMEMBERED_NS


class Arrivals(NamedTuple):
    """The frames of a delivery, at `time_ns` of simulation time, and why they are refused, or None.

    receiver, source and arrived_ns have an entry per frame: the index of the receiver, the number
    of the sender, and the time of arrival.
    """

    cycle: int
    time_ns: int
    frames: Frames
    receiver: Ints
    source: Ints
    arrived_ns: Ints

    @property
    def fault(self) -> str | None:
        """Why the frames are refused, or None."""
        return self.frames.fault


class Arriving:
    """Reads deliveries to some vehicles, and recognises frames that are repeated.

    As for `SeenFrames`, a frame is known by its receiver, its source and its arrival.
    """

    def __init__(self, hearing: Hearing, vehicles: Sequence[int], size: int) -> None:
        self._hearing, self._vehicles, self._size = hearing, np.array(vehicles), size
        self._known: set[int] = set()
        self._order: deque[tuple[int, list[int]]] = deque()  # by time of delivery
        self._newest_ns = 0

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
        return Arrivals(delivery.cycle, time_ns, frames, receiver, source, arrived_ns)

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

    def are_new(self, arrivals: Arrivals) -> bool:
        """Return whether a delivery has frames that are all new; if so, remember them."""
        # One number per frame: sets of numbers take a third of the time of sets of pairs.
        links = len(self._vehicles) * (self._size + 1)
        link = arrivals.receiver * (self._size + 1) + arrivals.source
        rows = (arrivals.arrived_ns * links + link).tolist()
        oldest_ns = self._newest_ns - REMEMBERED_NS
        if not self._known.isdisjoint(rows) or int(arrivals.arrived_ns.min()) <= oldest_ns:
            return False
        self._known.update(rows)
        self._order.append((int(arrivals.arrived_ns.max()), rows))
        self._newest_ns = max(self._newest_ns, self._order[-1][0])
        while self._order[0][0] <= self._newest_ns - REMEMBERED_NS:
            self._known.difference_update(self._order.popleft()[1])
        return True


def columns_by_receiver(received: Sequence[tuple[Arrivals, int]], count: int) -> Iterator[bytes]:
    """Yield the columns of a `pb.Timing` with the frames to each of `count` receivers.

    received: deliveries, in order, and when they came (ns of simulation time).
    """
    if not received:
        yield from [b""] * count
        return
    receiver, source, arrived_ns, came_ns = (
        np.concatenate(columns)
        for columns in zip(
            *(
                (one.receiver, one.source, one.arrived_ns, np.full(len(one.source), came_ns))
                for one, came_ns in received
            ),
            strict=True,
        )
    )
    order = np.argsort(receiver, kind="stable")
    ends = np.searchsorted(receiver[order], np.arange(count), side="right").tolist()
    columns = [
        (tag(number, 2), 4 if dtype == "<u4" else 8, values[order].astype(dtype).tobytes())
        for number, dtype, values in (
            (pb.Timing.SOURCE_FIELD_NUMBER, "<u4", source),
            (pb.Timing.ARRIVED_NS_FIELD_NUMBER, "<i8", arrived_ns),
            (pb.Timing.CAME_NS_FIELD_NUMBER, "<i8", came_ns),
        )
    ]
    start = 0
    for end in ends:
        pieces: list[bytes] = []
        for head, width, data in columns if end > start else ():
            pieces += (head, varint(width * (end - start)), data[width * start : width * end])
        yield b"".join(pieces)
        start = end
