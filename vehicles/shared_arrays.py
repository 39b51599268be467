"""The vehicles of a shared process in lock-step, as arrays: the same messages, in less time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.bus import deliveries
from zenvoy.bus.agent import Barrier, Decoder, Envelope, Inbox
from zenvoy.bus.bundles import unpack
from zenvoy.bus.topics import BEACON, COMMAND, RECEIVE, SENSE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.vehicles.arrays.estimates import Estimates
from zenvoy.vehicles.arrays.heard import Frames, Hearing
from zenvoy.vehicles.arrays.sending import Sending
from zenvoy.vehicles.arrays.senses import Sensed, Sensing
from zenvoy.vehicles.arrays.vehicles import Vehicles


class ArrayVehicles:
    """Sends what `LockStepVehicles` sends, for the vehicles that `arrays.suited` allows.

    It takes the senses of all its vehicles as one message, and what they receive as another.
    """

    role = "vehicle"

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        members = [roster(scenario)[vehicle - 1] for vehicle in self.vehicles]
        core = self._core = Vehicles([scenario], self.vehicles)
        links = core.links_in_use
        if core.links.behind[0] not in links:
            links.append(core.links.behind[0])  # a command tells the age of its newest beacon
        self._sensing: Final = Sensing(scenario, self.vehicles)
        self._hearing: Final = Hearing(scenario, core.timing, links, self.vehicles)
        self._sending: Final = Sending(scenario, core.timing, self.vehicles)
        self._beaconing = Beaconing(scenario, members, self.vehicles)
        self.decoders: Mapping[Topic[Any], Decoder] = {SENSE: self._sensed, RECEIVE: self._heard}
        self._period_ns, self._wait_ns = scenario.period_ns, scenario.v2v_wait_ns
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
            return Barrier(start_ns, self._cycle, ((SENSE, (0,)),))
        return Barrier(start_ns + self._wait_ns, self._cycle, ((RECEIVE, (0,)),))

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Sensed | Frames) -> str | None:
        """Return why messages are refused, or None, as a vehicle of its own does.

        It also refuses what no other process of Zenvoy sends, and arrays cannot hold.
        """
        return message.fault

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """Return the beacons for senses, and the commands for receives; raises LawError."""
        if self._senses:
            self._senses = False
            sensed: Sensed = inbox.together(SENSE)
            sent = self._core.sense(sensed.senses)
            speaks, sequence = self._beaconing.at(self._cycle)
            return self._each(BEACON, self._sending.beacons(self._cycle, sent, speaks, sequence))
        self._senses = True
        frames: Frames = inbox.together(RECEIVE)
        for link, cycle, to, beacons in self._hearing.take_in(frames):
            self._core.hear(link, cycle, to, beacons)
        decisions = self._core.decide(wants_all=True)
        estimates = Estimates(self._core, decisions)
        cycle, self._cycle = self._cycle, self._cycle + 1
        return self._each(COMMAND, self._sending.commands(cycle, decisions, estimates))

    def _each(self, topic: Topic[Any], payloads: list[bytes]) -> list[Envelope]:
        pairs = zip(self.vehicles, payloads, strict=True)
        return [Envelope(topic, vehicle, payload) for vehicle, payload in pairs]

    def _sensed(self, bundle: bytes) -> Sensed:
        return self._sensing.read(unpack(bundle))

    def _heard(self, payload: bytes) -> Frames:
        return self._hearing.read(deliveries.decode(payload))
