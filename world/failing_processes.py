"""What the world does about vehicles whose processes fail."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import ProcessSlowed, Scenario, attendance, faults_of


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

    def taken_in(self, commands: Iterable[pb.Command]) -> list[pb.Command]:
        """Return the commands that take effect, in their order; those that are late are changed.

        A process answers in order, so a command does not overtake an earlier one that is late. The
        commands that a killed process leaves behind take no effect.
        """
        if not self._attendance.absences and not self._slowed:
            return list(commands)
        left = [command for command in commands if not self._is_dead(command)]
        for command in left:
            delays_ns = [
                fault.delay_ns
                for _, fault, vehicles in self._slowed
                if command.vehicle in vehicles and fault.in_force(command.time_ns)
            ]
            if delays_ns or command.vehicle in self._newest_ns:
                after_ns = self._newest_ns.get(command.vehicle, 0)
                command.effective_ns = max(command.effective_ns + sum(delays_ns), after_ns)
                self._newest_ns[command.vehicle] = command.effective_ns
        return left

    def _is_dead(self, command: pb.Command) -> bool:
        """Return whether the process of a command dies before the command takes effect."""
        return any(
            command.cycle < absence.first
            and command.effective_ns >= absence.first * self._period_ns
            for absence in self._attendance.kills(command.vehicle)
        )
