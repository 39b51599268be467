"""What the world does about vehicles whose processes fail."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from zenvoy.scenarios import ProcessSlowed, Scenario, attendance, faults_of
from zenvoy.world.commands import Rows


class Held(NamedTuple):
    """The acceleration (m/s²) of a vehicle from an instant on, until its next command."""

    vehicle: int
    from_ns: int
    acceleration: float


def held(scenario: Scenario) -> Iterator[Held]:
    """Yield what vehicles do while nobody drives them: they roll, or brake."""
    there = attendance(scenario)
    for vehicle in there.absences:
        for absence in there.kills(vehicle):
            assert absence.killed is not None
            brakes = scenario.on_vehicle_loss == "brake"
            acceleration = -absence.killed.deceleration_mps2 if brakes else 0.0
            yield Held(vehicle, absence.first * scenario.period_ns, acceleration)


class FailingProcesses:
    """Changes the commands of vehicles whose processes are slow or have been killed."""

    def __init__(self, scenario: Scenario) -> None:
        self._period_ns = scenario.period_ns
        self._attendance = attendance(scenario)
        self._slowed = list(faults_of(scenario, ProcessSlowed))
        self._newest_ns: dict[int, int] = {}  # by slow vehicle: effect of its newest command

    def taken_in(self, rows: Rows) -> Rows:
        """Return the commands that take effect, in order; rows: of `ROW`, late ones are changed.

        A process answers in order, so a command does not overtake an earlier one that is late. The
        commands that a killed process leaves behind take no effect.
        """
        if not self._attendance.absences and not self._slowed:
            return rows
        left = [at for at in range(len(rows)) if not self._is_dead(rows[at])]
        for at in left:
            vehicle, time_ns = int(rows["vehicle"][at]), int(rows["time_ns"][at])
            delays_ns = [
                fault.delay_ns
                for _, fault, vehicles in self._slowed
                if vehicle in vehicles and fault.in_force(time_ns)
            ]
            if delays_ns or vehicle in self._newest_ns:
                after_ns = self._newest_ns.get(vehicle, 0)
                effective_ns = max(int(rows["effective_ns"][at]) + sum(delays_ns), after_ns)
                rows["effective_ns"][at] = self._newest_ns[vehicle] = effective_ns
        return rows[left]

    def _is_dead(self, row: Rows) -> bool:
        """Return whether the process of a command dies before the command takes effect."""
        return any(
            row["cycle"] < absence.first and row["effective_ns"] >= absence.first * self._period_ns
            for absence in self._attendance.kills(int(row["vehicle"]))
        )
