"""What others have told: their newest beacons, and the states that follow from them."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter

from google.protobuf.message import DecodeError

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.checks import is_sane
from zenvoy.bus.mailbox import WINDOW
from zenvoy.vehicles.controllers import Told
from zenvoy.vehicles.neighbours import Neighbours
from zenvoy.vehicles.relative import Relative


class Radio:
    """The newest beacon of everyone who counts; older than `age_limit_ns` it counts as missing."""

    def __init__(self, neighbours: Neighbours, age_limit_ns: int) -> None:
        self._neighbours, self._everyone = neighbours, neighbours.everyone
        self._age_limit_ns = age_limit_ns
        self._heard: dict[int, pb.Beacon] = {}
        # What was read before it was heard, by cycle.
        self._read: dict[int, tuple[pb.Receive, list[pb.Beacon | None]]] = {}
        self._time_ns = 0

    def understands(self, receive: pb.Receive, time_ns: int) -> bool:
        """Whether all that counts in the frames of the cycle of `time_ns` makes sense.

        It is not read again when it is heard.
        """
        beacons = self._beacons_in(receive, time_ns)
        if not all(beacons):
            return False
        if len(self._read) > WINDOW:
            self._read.clear()
        self._read[receive.cycle] = receive, beacons
        return True

    def hear(self, receive: pb.Receive, time_ns: int) -> list[pb.Beacon]:
        """Take in the frames that came in the cycle of `time_ns`; the news, oldest first."""
        self._time_ns = time_ns
        read, beacons = self._read.pop(receive.cycle, (None, []))
        if read is not receive:
            beacons = self._beacons_in(receive, time_ns)
        news = []
        for beacon in sorted(filter(None, beacons), key=attrgetter("time_ns")):
            heard = self._heard.get(beacon.vehicle)
            if heard is None or beacon.time_ns > heard.time_ns:
                self._heard[beacon.vehicle] = beacon
                news.append(beacon)
        return news

    def age_ns(self, vehicle: int) -> int:
        """Age of the newest beacon of a vehicle; -1 where there is none yet."""
        heard = self._heard.get(vehicle)
        return -1 if heard is None else self._time_ns - heard.time_ns

    def fresh(self, vehicle: int) -> pb.Beacon | None:
        """The newest beacon of a vehicle, unless it is too old."""
        heard = self._heard.get(vehicle)
        if heard is None or self._time_ns - heard.time_ns > self._age_limit_ns:
            return None
        return heard

    def told(self, vehicle: int) -> Told | None:
        """What a vehicle says of its motion: speed, and the acceleration in force."""
        beacon = self.fresh(vehicle)
        if beacon is None:
            return None
        plan = beacon.planned_acceleration
        return Told(beacon.speed, plan[0] if plan else beacon.acceleration)

    def radar_of(self, vehicle: int) -> pb.Link | None:
        """A vehicle's own radar reading."""
        beacon = self.fresh(vehicle)
        return beacon.ahead if beacon is not None and beacon.HasField("ahead") else None

    def chains(self, own: pb.Link | None) -> tuple[list[Relative], list[Relative]]:
        """States to the 1st, 2nd, ... vehicle ahead and behind, as sums of radar readings.

        Each list ends before the first reading that is missing; `own` is the own radar's.
        """
        ahead = [own, *map(self.radar_of, self._neighbours.ahead[:-1])]
        behind = list(map(self.radar_of, self._neighbours.behind))
        return _summed(ahead), _summed(behind)

    def positions(self, here: float, v: float) -> tuple[list[Relative], list[Relative]]:
        """The same from reported positions against the own position `here` (m) and speed v."""
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

    def _beacons_in(self, receive: pb.Receive, time_ns: int) -> list[pb.Beacon | None]:
        """Beacons of those who count, in order of arrival; None for what makes no sense."""
        everyone, payloads = self._everyone, receive.beacon
        return [
            _understood(payloads[row], source, time_ns)
            for row, source in enumerate(receive.source[:])  # a list is faster to go through
            if source in everyone
        ]


def _understood(payload: bytes, source: int, time_ns: int) -> pb.Beacon | None:
    """Beacon in a frame; None where it makes no sense: anyone may send anything."""
    try:
        beacon = pb.Beacon.FromString(payload)
    except DecodeError:
        return None
    makes_sense = (
        is_sane(beacon)
        and beacon.vehicle == source
        and beacon.time_ns <= time_ns
        and len(beacon.planned_acceleration) == len(beacon.planned_from_ns)
    )
    return beacon if makes_sense else None


def _summed(links: Sequence[pb.Link | None]) -> list[Relative]:
    """States over 1, 2, ... links, up to the first that is missing."""
    sums: list[Relative] = []
    p = v = 0.0
    for link in links:
        if link is None:
            break
        p, v = p + link.gap, v + link.speed
        sums.append(Relative(p, v))
    return sums
