"""Beacons in real time, while they wait for the others of their cycle. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from zenvoy.channel.agent import Sent
from zenvoy.scenarios import Scenario

# All in ns of wall time.
_GUARD_NS: Final = 5_000_000  # after t_k, the beacons that are there go on the air without the rest
_PREPARE_NS: Final = 3_000_000  # from putting frames on the air to being able to deliver the first
_BUSY_NS: Final = 12_000_000  # longer than the guard time, where the machine is busy
_MANY: Final = 4  # vehicles: where so many are missing, the machine is busy
_GATHER_NS: Final = 5_000_000  # beacons that missed their cycle's first transmission wait so long


@dataclass(slots=True, kw_only=True)
class _Waiting:
    """Beacons of a cycle, by vehicle, and when the first of them came (ns)."""

    since_ns: int
    beacons: dict[int, Sent] = field(default_factory=dict)


class Gathering:
    """Keeps the beacons of each cycle until they are transmitted, and says when that is at latest.

    A beacon that misses the first transmission of its cycle costs everyone in range one more
    message. So the first transmission waits for the vehicles that took part in the cycle before:
    as long as the first frame can still come at its instant (the guard time), and longer where so
    many are missing that the machine is busy. A vehicle that missed a cycle may be gone, and nobody
    waits for it.

    Beacons that come after it wait for one another in the same way, for a shorter time.
    """

    def __init__(self, scenario: Scenario, least_latency_ns: int) -> None:
        vehicles = range(1, scenario.fleet.size + 1)
        self._period_ns = scenario.period_ns
        self._guard_ns = max(
            round(_GUARD_NS * scenario.speed),
            least_latency_ns - round(_PREPARE_NS * scenario.speed),
        )
        self._busy_ns = round(_BUSY_NS * scenario.speed)
        self._gather_ns = round(_GATHER_NS * scenario.speed)
        self._waiting: dict[int, _Waiting] = {}  # by cycle
        self._newest = dict.fromkeys(vehicles, -1)  # cycle of the newest beacon of each vehicle
        self._cycle = -1  # the newest cycle of which anything was transmitted
        self._present = set(vehicles)  # whose beacons of that cycle were
        self._missing = set[int]()  # who was present in the cycle before, but is not in that one

    @property
    def cycles(self) -> Iterable[int]:
        """Cycles of which beacons are waiting."""
        return self._waiting.keys()

    def add(self, cycle: int, vehicle: int, beacon: Sent, came_ns: int) -> bool:
        """Keep a beacon; False where there was one of the same cycle, or a newer one."""
        if cycle <= self._newest[vehicle]:
            return False
        self._newest[vehicle] = cycle
        waiting = self._waiting.setdefault(cycle, _Waiting(since_ns=came_ns))
        waiting.beacons[vehicle] = beacon
        return True

    def transmits_ns(self, cycle: int) -> int:
        """When the beacons of a cycle that are waiting go on the air, at the latest (ns)."""
        waiting = self._waiting[cycle]
        here = waiting.beacons.keys()
        if cycle <= self._cycle:  # the first transmission of the cycle has been
            return waiting.since_ns + (self._gather_ns if self._missing - here else 0)
        start_ns = cycle * self._period_ns
        missing = len(self._present - here)
        if not missing:
            return start_ns
        return start_ns + self._guard_ns + (self._busy_ns if missing >= _MANY else 0)

    def take_out(self, cycle: int) -> dict[int, Sent]:
        """The beacons of a cycle that are waiting, by vehicle, to be transmitted now."""
        beacons = self._waiting.pop(cycle).beacons
        if cycle > self._cycle:
            self._missing = self._present - beacons.keys()
            self._cycle, self._present = cycle, set(beacons)
        elif cycle == self._cycle:
            self._missing -= beacons.keys()
            self._present |= beacons.keys()
        return beacons

    def forget(self, until_cycle: int) -> None:
        """Drop the beacons of all cycles up to one: they are too old."""
        for cycle in [one for one in self._waiting if one <= until_cycle]:
            del self._waiting[cycle]
