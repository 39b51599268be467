"""Which vehicles take part in which cycles: all of them, unless their processes fail."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from zenvoy.scenarios.schema.fault import NEVER_NS
from zenvoy.scenarios.schema.faults import faults_of
from zenvoy.scenarios.schema.faults_of_processes import ProcessFrozen, ProcessKilled

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario


class Absence(NamedTuple):
    """The cycles, from `first` to before `end`, in which a vehicle takes no part.

    killed: the fault that killed its process; None if that is only frozen.
    """

    first: int
    end: int
    killed: ProcessKilled | None


class Attendance:
    """The absences of a scenario. Cycles are those whose start lies within a fault."""

    def __init__(self, scenario: Scenario) -> None:
        self._cycles = scenario.cycles
        self.everyone: Sequence[int] = range(1, scenario.fleet.size + 1)
        self.absences: dict[int, list[Absence]] = {}
        """By vehicle, in order of time; only vehicles that are absent at all."""
        self._add(faults_of(scenario, ProcessFrozen), scenario)
        self._add(faults_of(scenario, ProcessKilled), scenario)
        for absences in self.absences.values():
            absences.sort(key=lambda absence: absence.first)

    def _add(
        self,
        faults: Iterable[tuple[int, ProcessFrozen | ProcessKilled, tuple[int, ...]]],
        scenario: Scenario,
    ) -> None:
        for _, fault, vehicles in faults:
            absence = _absence(fault, scenario.period_ns, scenario.cycles)
            for vehicle in vehicles if absence.first < scenario.cycles else ():
                self.absences.setdefault(vehicle, []).append(absence)

    def there(self, cycle: int) -> Sequence[int]:
        """Return the vehicles that take part in a cycle, in order."""
        if not self.absences:
            return self.everyone
        return [vehicle for vehicle in self.everyone if self.takes_part(vehicle, cycle)]

    def takes_part(self, vehicle: int, cycle: int) -> bool:
        """Return whether a vehicle takes part in a cycle."""
        if not self.absences:  # nearly always, and this is asked for every message
            return True
        absences = self.absences.get(vehicle, ())
        return not any(absence.first <= cycle < absence.end for absence in absences)

    def next(self, vehicle: int, cycle: int) -> int:
        """Return the first cycle from `cycle` on in which a vehicle takes part, or the end."""
        for absence in self.absences.get(vehicle, ()):
            if absence.first <= cycle < absence.end:
                return absence.end
        return min(cycle, self._cycles)

    def kills(self, vehicle: int) -> list[Absence]:
        """Return the absences that begin with the death of the vehicle's process."""
        return [one for one in self.absences.get(vehicle, ()) if one.killed is not None]

    def lives(self, vehicle: int) -> list[range]:
        """Return the cycles of each process of a vehicle, from its first to before its death."""
        kills = self.kills(vehicle)
        begins, ends = [0, *(k.end for k in kills)], [*(k.first for k in kills), self._cycles]
        return [range(*ends_of) for ends_of in zip(begins, ends, strict=True)]

    def killed_at(self, cycle: int) -> list[int]:
        """Return the vehicles whose processes are killed at the start of a cycle, in order."""
        return [
            vehicle
            for vehicle in sorted(self.absences)
            if any(absence.first == cycle for absence in self.kills(vehicle))
        ]

    def joining_at(self, cycle: int) -> list[int]:
        """Return the vehicles that new processes drive from a cycle of the run on, in order."""
        return [
            vehicle
            for vehicle in sorted(self.absences)
            if any(absence.end == cycle < self._cycles for absence in self.kills(vehicle))
        ]


def _absence(fault: ProcessFrozen | ProcessKilled, period_ns: int, cycles: int) -> Absence:
    first = -(-fault.start_ns // period_ns)
    killed = fault if isinstance(fault, ProcessKilled) else None
    end = cycles if fault.end_ns == NEVER_NS else min(cycles, -(-fault.end_ns // period_ns))
    # A process that is killed misses at least a cycle.
    return Absence(first, max(end, first + (killed is not None)), killed)


def attendance(scenario: Scenario) -> Attendance:
    """Return who takes part in the cycles of a scenario; every agent of a run asks for it."""
    # Each look-up hashes the scenario, which takes longer than to find that nobody is ever absent.
    return _remembered(scenario) if scenario.faults else Attendance(scenario)


@lru_cache(maxsize=8)
def _remembered(scenario: Scenario) -> Attendance:
    return Attendance(scenario)
