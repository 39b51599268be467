"""A vehicle in lock-step: it waits for its sense, then for its frames, in every cycle."""

from __future__ import annotations

from typing import Any

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.topics import RECEIVE, SENSE, Topic
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.agent import Vehicle


class LockStepVehicle:
    """Sends a beacon when its sense has arrived, and a command when its frames have."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, vehicle: int) -> None:
        self._core = Vehicle(scenario, vehicle)
        self.name, self.vehicles = self._core.name, (vehicle,)
        self._period_ns, self._cycles = scenario.period_ns, scenario.cycles
        self._wait_ns = scenario.v2v_wait_ns
        self._cycle = 0
        self._senses = True
        self._needs_sense = ((SENSE, (vehicle,)),)
        self._needs_receive = ((RECEIVE, (vehicle,)),)

    @property
    def barrier(self) -> Barrier | None:
        """The sense of the cycle, then the receive of the cycle; None after the last cycle."""
        if self._cycle == self._cycles:
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
        self._cycle += 1
        return [self._core.decide(now_ns, (inbox.one(RECEIVE),))]
