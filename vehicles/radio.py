"""The newest beacons that a vehicle has received, and the states that follow from them."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Relative
from zenvoy.laws.relative import NAN
from zenvoy.vehicles.neighbours import Neighbours
from zenvoy.vehicles.received import ReceivedBeacon, beacon_in
from zenvoy.vehicles.steps import NS


class Radio:
    """The newest beacon of each neighbour; beyond `age_limit_ns` it counts as missing."""

    def __init__(self, neighbours: Neighbours, age_limit_ns: int) -> None:
        self._neighbours, self._everyone = neighbours, neighbours.everyone
        self._age_limit_ns = age_limit_ns
        self._newest: dict[int, ReceivedBeacon] = {}
        self._time_ns = 0

    def understands(self, receive: pb.Receive, time_ns: int) -> bool:
        """Return whether all frames of neighbours make sense, and were sent by `time_ns`."""
        return all(self._beacons_in(receive, time_ns))

    def take_in(self, received: Sequence[pb.Receive], time_ns: int) -> list[ReceivedBeacon]:
        """Take in the frames of the cycle that starts at `time_ns`; return the new beacons.

        The oldest beacon comes first.
        """
        self._time_ns = time_ns
        beacons = [b for one in received for b in self._beacons_in(one, time_ns) if b is not None]
        beacons.sort(key=attrgetter("time_ns"))
        news = []
        for beacon in beacons:
            before = self._newest.get(beacon.vehicle)
            if before is None or beacon.time_ns > before.time_ns:
                self._newest[beacon.vehicle] = beacon
                news.append(beacon)
        return news

    def age_ns(self, vehicle: int) -> int:
        """Return the age of the newest beacon of a vehicle, ns; -1 if there is none yet."""
        newest = self._newest.get(vehicle)
        return -1 if newest is None else self._time_ns - newest.time_ns

    def fresh(self, vehicle: int) -> ReceivedBeacon | None:
        """Return the newest beacon of a vehicle; None if there is none, or if it is too old."""
        newest = self._newest.get(vehicle)
        if newest is None or self._time_ns - newest.time_ns > self._age_limit_ns:
            return None
        return newest

    def motion_of(
        self, vehicle: int, from_m: float, steps: int, *, commands: bool
    ) -> Motion | None:
        """Return what a vehicle reports of its motion, with the acceleration in force.

        Its distance counts from `from_m`; it is the `steps`-th vehicle ahead. A report that lacks
        its command is missing if `commands` are asked for.
        """
        beacon = self.fresh(vehicle)
        if beacon is None or (commands and beacon.command is None):
            return None
        plan = beacon.planned_acceleration
        return Motion(
            beacon.speed,
            plan[0] if plan else beacon.acceleration,
            beacon.position - from_m,
            (self._time_ns - beacon.time_ns) * NS,
            NAN if beacon.command is None or not commands else beacon.command,
            steps,
        )

    def radar_of(self, vehicle: int) -> Relative | None:
        """Return the radar reading that a vehicle reports; None if it is missing or too old."""
        beacon = self.fresh(vehicle)
        return None if beacon is None else beacon.radar

    def chains(self, own: Relative | None) -> tuple[list[Relative], list[Relative]]:
        """Return states to the 1st, 2nd, ... vehicle ahead and behind, as sums of radar readings.

        Each list ends before the first missing reading. `own` is the reading of the own radar.
        """
        ahead = [own, *map(self.radar_of, self._neighbours.ahead[:-1])]
        behind = list(map(self.radar_of, self._neighbours.behind))
        return _summed(ahead), _summed(behind)

    def positions(self, here: float, v: float) -> tuple[list[Relative], list[Relative]]:
        """Return the same states from reported positions, own position `here` (m) and speed v."""
        neighbours = self._neighbours
        ahead, behind = [], []
        for other, seam in zip(neighbours.ahead, neighbours.seam_ahead, strict=True):
            if (beacon := self.fresh(other)) is None:
                break
            ahead.append(Relative(beacon.position + seam - here, beacon.speed - v))
        for other, seam in zip(neighbours.behind, neighbours.seam_behind, strict=True):
            if (beacon := self.fresh(other)) is None:
                break
            behind.append(Relative(here - beacon.position + seam, v - beacon.speed))
        return ahead, behind

    def _beacons_in(self, receive: pb.Receive, time_ns: int) -> list[ReceivedBeacon | None]:
        """Return the beacons of neighbours, in order of arrival; None for one without sense."""
        everyone, payloads = self._everyone, receive.beacon
        return [
            beacon
            if (beacon := beacon_in(payloads[row]))
            and beacon.vehicle == source
            and beacon.time_ns <= time_ns
            else None
            for row, source in enumerate(receive.source[:])  # iterating over a list is faster
            if source in everyone
        ]


def _summed(links: Sequence[Relative | None]) -> list[Relative]:
    """Return the states over 1, 2, ... links, up to the first missing one."""
    sums: list[Relative] = []
    p = v = 0.0
    for link in links:
        if link is None:
            break
        p, v = p + link.p, v + link.v
        sums.append(Relative(p, v))
    return sums
