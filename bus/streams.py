"""The streams of a participant: their keys, who owns them, and which process reads them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from zenvoy.bus.agent import Participant
from zenvoy.bus.topics import TOPICS, Topic, vehicle_name
from zenvoy.bus.wiring import Wiring

Owner = int | frozenset[int]
"""A vehicle (0: none), or the vehicles of a shared process."""


class Streams:
    """The streams that a participant of a run reads and writes."""

    def __init__(self, participant: Participant, wiring: Wiring) -> None:
        self._participant = participant
        self._wiring = wiring
        self.shared_by = {
            vehicle: process for process in wiring.shared_processes for vehicle in process.vehicles
        }
        """The shared process of each vehicle that has one."""
        self.keys = {
            (topic, vehicle): self._key(topic, vehicle)
            for topic in TOPICS
            if topic.is_open(wiring.public)
            for vehicle in (wiring.vehicles if topic.per_vehicle else (0,))
        }
        """The key of each stream, by topic and vehicle (0: none)."""
        self.owners: Mapping[Topic[Any], Mapping[str, Owner]] = {
            topic: self._owners(topic)
            for topic in TOPICS
            if topic.reader == participant.role and topic.pattern is not None
        }
        """The owner of each key that the participant reads, by topic."""

    def process(self, role: str, vehicle: int) -> str:
        """Return the name of the process of a role, or of a vehicle."""
        if role != "vehicle":
            return role
        shared = self.shared_by.get(vehicle)
        return vehicle_name(vehicle, len(self._wiring.vehicles)) if shared is None else shared.name

    @property
    def driven(self) -> dict[str, Sequence[int]]:
        """The vehicles of each process that the fleet may have, alone or shared."""
        vehicles = self._wiring.vehicles
        alone: dict[str, Sequence[int]] = {
            vehicle_name(one, len(vehicles)): (one,) for one in vehicles
        }
        return alone | {one.name: one.vehicles for one in self._wiring.shared_processes}

    def read(self, topic: Topic[Any]) -> str:
        """Return the key expression of what the participant reads of a topic."""
        vehicles = self._participant.vehicles
        return self.keys[topic, vehicles[0]] if vehicles else topic.keys(self._wiring.run)

    def written(self, fleet: Iterable[int]) -> dict[str, str]:
        """Return the keys that it writes for a fleet, each with the process that reads it.

        The process is "" if no reader is required.
        """
        agent = self._participant
        return {
            self.keys[topic, vehicle]: (
                self.process(topic.reader, vehicle) if topic.reader and topic.is_awaited else ""
            )
            for topic in TOPICS
            if topic.writer == agent.role and topic.is_open(self._wiring.public)
            for vehicle in (agent.vehicles or fleet if topic.per_vehicle else (0,))
        }

    def _key(self, topic: Topic[Any], vehicle: int) -> str:
        """Return the key of a topic of a vehicle (0: none), or of its shared process."""
        process, run = self.shared_by.get(vehicle), self._wiring.run
        return topic.key(run, vehicle) if process is None else topic.shared_key(run, process.name)

    def _owners(self, topic: Topic[Any]) -> dict[str, Owner]:
        """Return the owner of each key of a topic that the participant reads."""
        vehicles = self._participant.vehicles or self._wiring.vehicles
        found: dict[str, Owner] = {}
        for vehicle in vehicles if topic.per_vehicle else (0,):
            process = self.shared_by.get(vehicle)
            owner = vehicle if process is None else frozenset(process.vehicles)
            found[self.keys[topic, vehicle]] = owner
        return found
