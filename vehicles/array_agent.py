"""The vehicles of a process as arrays, under either clock: the same messages, in less time.

`agent` does the same for one vehicle. `shared_arrays` and `realtime_arrays` decide when.
"""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from typing import Any, Final

from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import BEACON, COMMAND, Topic
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.vehicles.arrays.estimates import Estimates
from zenvoy.vehicles.arrays.heard import Frames, Hearing
from zenvoy.vehicles.arrays.sending import Sending
from zenvoy.vehicles.arrays.senses import Sensing
from zenvoy.vehicles.arrays.vehicles import Senses, Vehicles


class VehicleArrays:
    """The vehicles of a process that `arrays.suited` allows.

    In each cycle, call `sense`, then `hear` for the frames that count, then `decide` or `pass_by`.
    """

    def __init__(self, scenario: Scenario, process: VehicleProcess) -> None:
        self.vehicles = process.vehicles
        members = [roster(scenario)[vehicle - 1] for vehicle in self.vehicles]
        core = self._core = Vehicles([scenario], self.vehicles)
        links = core.links_in_use
        if core.links.behind[0] not in links:
            links.append(core.links.behind[0])  # a command tells the age of its newest beacon
        self.sensing: Final = Sensing(scenario, self.vehicles)
        self.hearing: Final = Hearing(scenario, core.timing, links, self.vehicles)
        self._sending: Final = Sending(scenario, core.timing, self.vehicles)
        self._beaconing = Beaconing(scenario, members, self.vehicles)

    @property
    def cycle(self) -> int:
        """The newest cycle; -1 before the first."""
        return self._core.cycle

    def sense(self, senses: Senses) -> list[Envelope]:
        """Begin the next cycle, and return the beacons, in order."""
        sent = self._core.sense(senses)
        speaks, sequence = self._beaconing.at(self.cycle)
        return self._each(BEACON, self._sending.beacons(self.cycle, sent, speaks, sequence))

    def hear(self, received: Iterable[Frames]) -> None:
        """Take in the frames that arrived since the last decision, the oldest beacons first."""
        heard = [one for frames in received for one in self.hearing.take_in(frames)]
        for link, cycle, to, beacons in sorted(heard, key=attrgetter("cycle")):
            self._core.hear(link, cycle, to, beacons)

    def decide(self) -> list[Envelope]:
        """Return the commands of the cycle, in order; raises LawError."""
        decisions = self._core.decide(wants_all=True)
        estimates = Estimates(self._core, decisions)
        return self._each(COMMAND, self._sending.commands(self.cycle, decisions, estimates))

    def pass_by(self) -> None:
        """End the cycle without commands: those in force stay in force; raises LawError."""
        self._core.pass_by()

    def _each(self, topic: Topic[Any], payloads: list[bytes]) -> list[Envelope]:
        pairs = zip(self.vehicles, payloads, strict=True)
        return [Envelope(topic, vehicle, payload) for vehicle, payload in pairs]
