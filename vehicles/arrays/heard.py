"""The beacons in the frames of vehicles that run as arrays, by link and cycle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.refusals import ABSURD, FOREIGN, MISTIMED
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.plans import Plan
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints
from zenvoy.vehicles.arrays.sending import Form, table_of
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.control import reports_commands

_READ = ("position", "speed", "acceleration", "ahead_gap", "ahead_speed", "commanded_acceleration")


class Heard(NamedTuple):
    """The beacons of a cycle that a link delivers; to is a mask of the receivers."""

    link: Link
    cycle: int
    to: Bools
    beacons: Beacons


class Said(NamedTuple):
    """What some beacons say.

    sender is an index in the fleet, cycle that of the beacon. numbers has a row for each of _READ
    and for each entry of a plan. bare says whether a plan has only its first entry.
    """

    sender: Ints
    cycle: Ints
    numbers: Floats
    bare: Bools


class Frames(NamedTuple):
    """The frames on the links of a delivery, and why they are refused, or None.

    receiver, link and beacon have an entry per frame and link, with indices.
    """

    cycle: int
    receiver: Ints
    link: Ints
    beacon: Ints
    said: Said | None
    fault: str | None = None


class Hearing:
    """Reads the frames of some vehicles, on the links that they use.

    Arrays hold the plans that vehicles of this project send, and no others: a beacon with another
    plan makes no sense here.
    """

    def __init__(
        self, scenario: Scenario, timing: Timing, links: Sequence[Link], vehicles: Sequence[int]
    ) -> None:
        self._timing, self._size = timing, scenario.fleet.size
        self._links, self._vehicles = links, np.array(vehicles)
        self._senders = np.array([link.sender for link in links]) + 1
        self._first = 0 if scenario.ring_length_m is not None else 1  # it has no radar reading
        self._commands = reports_commands(scenario)
        forms = [
            Form(radar, entries, self._commands)
            for radar in (False, True)
            for entries in range(1, timing.lag + 1)
        ]
        self._forms = {table_of(form).size: form for form in forms}

    def read(self, delivery: Delivery) -> Frames:
        """Return the frames on the links in lock-step; a fault says why they are all refused."""
        start_ns = delivery.cycle * self._timing.period_ns
        if not np.array_equal(delivery.vehicle, self._vehicles):
            return refused(delivery.cycle, FOREIGN)
        if (delivery.time_ns != start_ns + self._timing.wait_ns).any():
            return refused(delivery.cycle, MISTIMED)
        counts = np.diff(delivery.ends, prepend=0)
        return self.frames(delivery, np.repeat(np.arange(len(counts)), counts), start_ns)

    def frames(self, delivery: Delivery, receiver: Ints, sent_by_ns: int) -> Frames:
        """Return the frames on the links; a fault says why they are all refused.

        receiver: the index of the receiver among these vehicles, by frame. sent_by_ns: the latest
        time at which a beacon can have been sent.
        """
        hits = delivery.source[delivery.beacon] == self._senders[:, receiver]
        link, row = np.nonzero(hits)
        used, beacon = np.unique(delivery.beacon[row], return_inverse=True)
        payloads = [delivery.beacons[one] for one in used.tolist()]
        said = self._said(payloads, delivery.source[used], sent_by_ns)
        fault = ABSURD if said is None else None
        return Frames(delivery.cycle, receiver[row], link, beacon, said, fault)

    def take_in(self, frames: Frames) -> Iterator[Heard]:
        """Yield what the links deliver, the oldest beacons first."""
        said = frames.said
        assert said is not None
        of_frame = said.cycle[frames.beacon]
        for cycle in np.unique(said.cycle).tolist():
            beacons = self._of_fleet(said, np.flatnonzero(said.cycle == cycle))
            heard = np.zeros((len(self._links), len(self._vehicles)), dtype=np.bool_)
            some = np.flatnonzero(of_frame == cycle)
            heard[frames.link[some], frames.receiver[some]] = True
            for number, link in enumerate(self._links):
                yield Heard(link, cycle, heard[number], beacons)

    def _said(self, payloads: Sequence[bytes], source: Ints, until_ns: int) -> Said | None:
        """Return what beacons say, which were sent by `until_ns`; None if any makes no sense."""
        count, lag = len(payloads), self._timing.lag
        numbers = np.full((len(_READ) + lag, count), NAN)
        plan = numbers[len(_READ) :]
        cycle, bare = np.zeros(count, np.int64), np.zeros(count, np.bool_)
        sizes = np.fromiter(map(len, payloads), np.int64, count)
        for size in np.unique(sizes).tolist():
            which = np.flatnonzero(sizes == size)
            form = self._forms.get(size)
            if form is None:
                return None
            read = table_of(form).decode([payloads[one] for one in which.tolist()])
            if read is None or not self._makes_sense(form, read, source[which], until_ns):
                return None
            for at, name in enumerate(_READ):
                if name in _names(read):
                    numbers[at, which] = read[name]
            cycle[which] = read["time_ns"] // self._timing.period_ns
            bare[which] = form.entries == 1
            # The only entry counts from the start; before cycle 0 nobody commanded anything.
            first = 0 if form.entries == 1 else lag - form.entries
            plan[:, which] = 0.0
            plan[first : first + form.entries, which] = read["planned_acceleration"].T
        return Said(source - 1, cycle, numbers, bare)

    def _makes_sense(self, form: Form, read: NDArray[Any], source: Ints, until_ns: int) -> bool:
        """Return whether vehicles of this project may have sent these beacons by `until_ns`."""
        time_ns, timing = read["time_ns"], self._timing
        cycle, since_ns = np.divmod(time_ns, timing.period_ns)
        if not np.array_equal(read["vehicle"], source) or since_ns.any():
            return False
        if (time_ns > until_ns).any() or ((source != self._first) != form.radar).any():
            return False
        numbers = [read[name] for name in _READ if name in _names(read)]
        if not all(np.isfinite(one).all() for one in (*numbers, read["planned_acceleration"])):
            return False
        starts_ns = np.array(timing.starts_of(form.entries))
        planned_ns = read["planned_from_ns"].reshape(len(read), -1)
        if (planned_ns != time_ns[:, None] + starts_ns).any():
            return False
        if form.entries == 1:
            return True
        # Before the first command is in force, nothing is.
        idle = (cycle >= timing.lag) | (read["planned_acceleration"][:, 0] == 0.0)
        return bool(idle.all() and (np.minimum(cycle + 1, timing.lag) == form.entries).all())

    def _of_fleet(self, said: Said, which: Ints) -> Beacons:
        """Return some beacons, all of one cycle, by vehicle of the fleet; the others are NaN."""
        table = np.full((len(said.numbers), self._size), NAN)
        sender = said.sender[which]
        table[:, sender] = said.numbers[:, which]
        bare = None
        if self._timing.lag > 1 and said.bare[which].any():
            bare = np.zeros(self._size, dtype=np.bool_)
            bare[sender] = said.bare[which]
        position, speed, acceleration, gap, relative_speed, command = table[: len(_READ)]
        read = position, speed, acceleration, gap, relative_speed
        plan = Plan(tuple(table[len(_READ) :]), bare)
        return Beacons(*read, plan, command if self._commands else None)


def refused(cycle: int, fault: str) -> Frames:
    """Return a delivery of which no frame is used."""
    nothing = np.zeros(0, np.int64)
    return Frames(cycle, nothing, nothing, nothing, None, fault)


def _names(read: NDArray[Any]) -> tuple[str, ...]:
    return read.dtype.names or ()
