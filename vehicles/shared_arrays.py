"""The vehicles of a shared process in lock-step, as arrays: the same messages, in less time."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from zenvoy.bus.agent import Barrier, Envelope, Inbox
from zenvoy.bus.checks import fault_in_receive, fault_in_sense
from zenvoy.bus.refusals import ABSURD, MALFORMED
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.vehicles.arrays.estimates import Estimates
from zenvoy.vehicles.arrays.heard import Hearing
from zenvoy.vehicles.arrays.sending import Sending
from zenvoy.vehicles.arrays.vehicles import Senses, Vehicles


class ArrayVehicles:
    """Sends what `LockStepVehicles` sends, for the vehicles that `arrays.suited` allows."""

    role = "vehicle"

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        members = [roster(scenario)[vehicle - 1] for vehicle in self.vehicles]
        core = self._core = Vehicles([scenario], self.vehicles)
        links = core.links_in_use
        if core.links.behind[0] not in links:
            links.append(core.links.behind[0])  # a command tells the age of its newest beacon
        self._hearing: Final = Hearing(scenario, core.timing, links, self.vehicles)
        self._sending: Final = Sending(scenario, core.timing, self.vehicles)
        self._beaconing = Beaconing(scenario, members, self.vehicles)
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
        self._first = 0 if scenario.ring_length_m is not None else 1  # its radar sees nobody
        self._cycles = scenario.cycles
        self._cycle = 0
        self._senses = True

    @property
    def barrier(self) -> Barrier | None:
        """The senses of the cycle, then its receives; None after the last cycle."""
        if self._cycle >= self._cycles:
            return None
        start_ns = self._cycle * self._period_ns
        if self._senses:
            return Barrier(start_ns, self._cycle, ((SENSE, self.vehicles),))
        return Barrier(start_ns + self._wait_ns, self._cycle, ((RECEIVE, self.vehicles),))

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return why a message is refused, or None, as a vehicle of its own does.

        It also refuses what no other process of Zenvoy sends, and arrays cannot hold.
        """
        start_ns = message.cycle * self._period_ns
        if topic is SENSE:
            if message.HasField("ahead") == (vehicle == self._first):
                return MALFORMED
            return fault_in_sense(message, vehicle, start_ns)
        fault = fault_in_receive(message, vehicle, start_ns + self._wait_ns)
        if fault is None and not self._hearing.understands(message, start_ns):
            return ABSURD
        return fault

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Return the beacons for senses, and the commands for receives; raises LawError."""
        if self._senses:
            self._senses = False
            sent = self._core.sense(self._readings(inbox))
            return self._each(
                BEACON, self._sending.beacons(self._cycle, sent, *self._beaconing.at(self._cycle))
            )
        self._senses = True
        for link, cycle, to, beacons in self._hearing.take_in(inbox.all(RECEIVE)):
            self._core.hear(link, cycle, to, beacons)
        decisions = self._core.decide(wants_all=True)
        estimates = Estimates(self._core, decisions)
        cycle, self._cycle = self._cycle, self._cycle + 1
        return self._each(COMMAND, self._sending.commands(cycle, decisions, estimates))

    def _each(self, topic: Topic[Any], payloads: list[bytes]) -> list[Envelope]:
        pairs = zip(self.vehicles, payloads, strict=True)
        return [Envelope(topic, vehicle, payload) for vehicle, payload in pairs]

    def _readings(self, inbox: Inbox) -> Senses:
        rows = [
            (
                one.position,
                one.speed,
                one.acceleration,
                *((one.ahead.gap, one.ahead.speed) if one.HasField("ahead") else (NAN, NAN)),
            )
            for one in inbox.all(SENSE)
        ]
        return Senses(*np.array(rows).T.copy())
