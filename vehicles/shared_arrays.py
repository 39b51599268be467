"""The vehicles of a shared process in lock-step, as arrays: the same messages, in less time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from zenvoy.bus import deliveries
from zenvoy.bus.agent import Barrier, Decoder, Envelope, Inbox
from zenvoy.bus.bundles import unpack
from zenvoy.bus.topics import RECEIVE, SENSE, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.array_agent import VehicleArrays
from zenvoy.vehicles.arrays.heard import Frames
from zenvoy.vehicles.arrays.senses import Sensed


class ArrayVehicles:
    """Sends what `LockStepVehicles` sends, for the vehicles that `arrays.suited` allows.

    It takes the senses of all its vehicles as one message, and what they receive as another.
    """

    role = "vehicle"

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.name, self.vehicles = process
        self._core: Final = VehicleArrays(scenario, process)
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
            return self._core.sense(sensed.senses)
        self._senses = True
        self._cycle += 1
        self._core.hear([inbox.together(RECEIVE)])
        return self._core.decide()

    def _sensed(self, bundle: bytes) -> Sensed:
        return self._core.sensing.read(unpack(bundle))

    def _heard(self, payload: bytes) -> Frames:
        return self._core.hearing.read(deliveries.decode(payload))
