"""In real time, beacons wait here for the others of their cycle. It reads no clock."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from zenvoy.channel.sent import Sent
from zenvoy.scenarios import Scenario

# All times are ns of wall time.
_GUARD_NS: Final = 5_000_000  # how long after t_k the first transmission waits for missing beacons
_PREPARE_NS: Final = 3_000_000  # from putting frames on the air to being able to deliver the first
_BUSY_NS: Final = 12_000_000  # added to the guard time if the machine is busy
_MANY: Final = 4  # vehicles: if so many are missing, the machine is busy
_GATHER_NS: Final = 5_000_000  # how long beacons that missed the first transmission wait for others


@dataclass(slots=True, kw_only=True)
class _Waiting:
    """The beacons of a cycle, by vehicle, and when the first of them arrived (ns)."""

    since_ns: int
    beacons: dict[int, Sent] = field(default_factory=dict)


class Gathering:
    """Keeps the beacons of each cycle, and says when they must be transmitted at the latest.

    A beacon that misses the first transmission of its cycle costs everyone in range one more
    message. So the first transmission waits for the vehicles that took part in the cycle before:
    as long as the first frame can still be delivered on time (the guard time), and longer if so
    many are missing that the machine must be busy. It does not wait for a vehicle that missed a
    cycle, because that vehicle may be gone.

    Beacons that arrive after the first transmission wait for each other in the same way, for a
    shorter time.
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
        self._cycle = -1  # the newest cycle with a transmission
        self._present = set(vehicles)  # vehicles whose beacons of that cycle were transmitted
        self._missing = set[int]()  # vehicles present in the cycle before, but not in that one

    @property
    def cycles(self) -> Iterable[int]:
        """The cycles whose beacons are waiting."""
        return self._waiting.keys()

    def add(self, cycle: int, vehicle: int, beacon: Sent, came_ns: int) -> bool:
        """Keep a beacon; return False if its vehicle has sent one of the same or a later cycle."""
        if not self.are_new(cycle, (vehicle,)):
            return False
        self._newest[vehicle] = cycle
        waiting = self._waiting.setdefault(cycle, _Waiting(since_ns=came_ns))
        waiting.beacons[vehicle] = beacon
        return True

    def are_new(self, cycle: int, vehicles: Iterable[int]) -> bool:
        """Return whether no vehicle has sent a beacon of that cycle or a later one."""
        return all(cycle > self._newest[vehicle] for vehicle in vehicles)

    def transmits_ns(self, cycle: int) -> int:
        """Return the latest time at which the waiting beacons of a cycle go on the air, ns."""
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
        """Remove the waiting beacons of a cycle and return them by vehicle, to be transmitted."""
        beacons = self._waiting.pop(cycle).beacons
        if cycle > self._cycle:
            self._missing = self._present - beacons.keys()
            self._cycle, self._present = cycle, set(beacons)
        elif cycle == self._cycle:
            self._missing -= beacons.keys()
            self._present |= beacons.keys()
        return beacons

    def forget(self, until_cycle: int) -> None:
        """Drop the beacons of all cycles up to this one: they are too old."""
        for cycle in [one for one in self._waiting if one <= until_cycle]:
            del self._waiting[cycle]
