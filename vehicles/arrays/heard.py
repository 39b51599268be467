"""The beacons in the frames of vehicles that run as arrays, by link and cycle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.plans import Plan
from zenvoy.vehicles.arrays.rows import Bools
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.control import reports_commands
from zenvoy.vehicles.received import ReceivedBeacon, beacon_in


class Heard(NamedTuple):
    """The beacons of a cycle that a link delivers; to is a mask of the receivers."""

    link: Link
    cycle: int
    to: Bools
    beacons: Beacons


class Hearing:
    """Reads the frames of some vehicles, on the links that they use.

    Arrays hold the plans that vehicles of this project send, and no others: a beacon with another
    plan makes no sense here.
    """

    def __init__(
        self, scenario: Scenario, timing: Timing, links: Sequence[Link], vehicles: Sequence[int]
    ) -> None:
        self._timing, self._size = timing, scenario.fleet.size
        self._links = links
        self._first = 0 if scenario.ring_length_m is not None else 1  # it has no radar reading
        self._commands = reports_commands(scenario)
        self._count = len(vehicles)
        self._slots: dict[int, dict[int, list[int]]] = {vehicle: {} for vehicle in vehicles}
        for number, link in enumerate(links):
            for vehicle, sender in zip(vehicles, link.sender.tolist(), strict=True):
                if sender >= 0:
                    self._slots[vehicle].setdefault(sender + 1, []).append(number)

    def understands(self, receive: pb.Receive, time_ns: int) -> bool:
        """Return whether all frames on the links make sense, and were sent by `time_ns`."""
        uses, payloads = self._slots[receive.vehicle], receive.beacon
        for row, source in enumerate(receive.source[:]):
            if source in uses:
                beacon = beacon_in(payloads[row])
                if beacon is None or beacon.time_ns > time_ns or not self._fits(source, beacon):
                    return False
        return True

    def take_in(self, received: Sequence[pb.Receive]) -> Iterator[Heard]:
        """Yield what the links deliver, the oldest beacons first.

        received: for each vehicle, in order.
        """
        beacons: dict[int, dict[int, ReceivedBeacon]] = {}
        heard: dict[int, Bools] = {}
        period_ns = self._timing.period_ns
        for at, receive in enumerate(received):
            uses, payloads = self._slots[receive.vehicle], receive.beacon
            for row, source in enumerate(receive.source[:]):
                numbers = uses.get(source)
                if numbers is None:
                    continue
                beacon = beacon_in(payloads[row])
                assert beacon is not None
                cycle = beacon.time_ns // period_ns
                if cycle not in beacons:
                    beacons[cycle] = {}
                    heard[cycle] = np.zeros((len(self._links), self._count), dtype=np.bool_)
                beacons[cycle][source] = beacon
                for number in numbers:
                    heard[cycle][number, at] = True
        for cycle in sorted(beacons):
            sent = self._together(cycle, beacons[cycle])
            for number, link in enumerate(self._links):
                yield Heard(link, cycle, heard[cycle][number], sent)

    def _fits(self, source: int, beacon: ReceivedBeacon) -> bool:
        """Return whether a vehicle of this project may have sent a beacon."""
        cycle, since_ns = divmod(beacon.time_ns, self._timing.period_ns)
        if beacon.vehicle != source or since_ns or beacon.report is not None:
            return False
        if (beacon.radar is None) != (source == self._first):
            return False
        if (beacon.command is None) == self._commands:
            return False
        known = min(cycle + 1, self._timing.lag)
        from_ns = tuple(time_ns - beacon.time_ns for time_ns in beacon.planned_from_ns)
        if from_ns == (0,):
            return True
        # Before the first command is in force, nothing is.
        idle = cycle >= self._timing.lag or beacon.planned_acceleration[:1] == (0.0,)
        return idle and from_ns == self._timing.starts_of(known)

    def _together(self, cycle: int, heard: Mapping[int, ReceivedBeacon]) -> Beacons:
        """Return the beacons of a cycle by vehicle of the fleet; those not heard are NaN."""
        index = np.fromiter(heard, np.int64, len(heard)) - 1
        lag = self._timing.lag
        nothing = (NAN, NAN)
        rows = []
        for one in heard.values():
            plan = one.planned_acceleration
            values = (0.0,) * (lag - len(plan)) + plan
            if len(plan) == 1:  # the only one counts from now on
                values = plan + (0.0,) * (lag - 1)
            read = (one.position, one.speed, one.acceleration, *(one.radar or nothing))
            rows.append((*read, NAN if one.command is None else one.command, *values))
        table = np.full((6 + lag, self._size), NAN)
        table[:, index] = np.array(rows).T
        bare = None
        if lag > 1:
            bare = np.zeros(self._size, dtype=np.bool_)
            bare[index] = [len(one.planned_acceleration) == 1 for one in heard.values()]
            bare = bare if bare.any() else None
        plans = Plan(tuple(table[6:]), bare)
        position, speed, acceleration, gap, relative_speed, command = table[:6]
        read = position, speed, acceleration, gap, relative_speed
        return Beacons(*read, plans, command if self._commands else None)
