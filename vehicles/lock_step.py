"""A vehicle in lock-step: it waits for its sense, then for its frames, in every cycle."""

from __future__ import annotations

from typing import Any

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.topics import RECEIVE, SENSE, Topic
from zenvoy.scenarios import Scenario, attendance
from zenvoy.vehicles.agent import Vehicle


class LockStepVehicle:
    """Sends a beacon when its sense has arrived, and a command when its frames have.

    It leaves out the cycles in which its process is frozen or has been killed. A process that
    replaces a killed one knows nothing of the earlier cycles. life: the number of a process, from
    0, which ends where it is killed; None: one after the other in the same process.
    """

    role = "vehicle"

    def __init__(self, scenario: Scenario, vehicle: int, life: int | None = None) -> None:
        self._scenario, self._vehicle = scenario, vehicle
        self._core = Vehicle(scenario, vehicle)
        self.name, self.vehicles = self._core.name, (vehicle,)
        self._period_ns = scenario.period_ns
        self._wait_ns = scenario.v2v_wait_ns
        self._attendance = attendance(scenario)
        lives = self._attendance.lives(vehicle)
        self._deaths = frozenset(one.stop for one in lives[:-1])
        self._end = scenario.cycles if life is None else lives[life].stop
        self._cycle = self._attendance.next(vehicle, lives[life or 0].start)
        self._senses = True
        self._needs_sense = ((SENSE, (vehicle,)),)
        self._needs_receive = ((RECEIVE, (vehicle,)),)

    @property
    def barrier(self) -> Barrier | None:
        """The sense of the cycle, then the receive of the cycle; None after the last cycle."""
        if self._cycle >= self._end:
            return None
        start_ns = self._cycle * self._period_ns
        if self._senses:
            return Barrier(start_ns, self._cycle, self._needs_sense)
        return Barrier(start_ns + self._wait_ns, self._cycle, self._needs_receive)

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None.

        Senses and receives must be for this vehicle and on time, and the beacons that count must
        make sense.
        """
        if topic is SENSE:
            return self._core.fault_in_sense(message)
        start_ns = message.cycle * self._period_ns
        return self._core.fault_in_receive(message, start_ns + self._wait_ns, start_ns)

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Return a beacon for a sense, and a command for a receive; raises LawError."""
        if self._senses:
            self._senses = False
            return [self._core.sense(inbox.one(SENSE))]
        self._senses = True
        command = self._core.decide(now_ns, (inbox.one(RECEIVE),))
        self._next()
        return [command]

    def _next(self) -> None:
        """Go to the next cycle in which the vehicle takes part."""
        following = self._cycle + 1
        self._cycle = self._attendance.next(self._vehicle, following)
        if following in self._deaths and self._cycle < self._end:
            self._core = Vehicle(self._scenario, self._vehicle)
