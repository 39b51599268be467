"""Bundles of shared processes: taken apart into real messages, and made of mutants."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
from google.protobuf.message import DecodeError

from tests.attack.messages import READ, Mutant, Seen
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import pack, parcels_in
from zenvoy.bus.deliveries import Delivery
from zenvoy.bus.topics import RECEIVE
from zenvoy.bus.vehicle_processes import VehicleProcess


class Bundler:
    """Takes real bundles of shared processes apart, and puts mutants into such bundles."""

    def __init__(self, run: str, shared: Sequence[VehicleProcess], seed: int) -> None:
        self._run, self._random = run, random.Random(seed)
        self._topics = {
            topic.shared_key(run, process.name): topic
            for process in shared
            for topic in READ
            if topic.per_vehicle
        }
        self._places = {
            topic.key(run, vehicle): (topic.shared_key(run, process.name), process, vehicle)
            for process in shared
            for vehicle in process.vehicles
            for topic in READ
            if topic.per_vehicle
        }

    def seen(self, key: str, payload: bytes) -> list[Seen]:
        """Return the real messages of a bundle."""
        topic = self._topics.get(key)
        if topic is None:
            return []
        return [
            Seen(topic, vehicle, one, topic.decode(one).cycle)
            for vehicle, one in parcels_in(topic, payload)
        ]

    def bundled(self, mutant: Mutant) -> Mutant:
        """Return the mutant in a bundle, a mutant of the bundle, or the mutant as it is."""
        key, payload, attachment = mutant
        if key not in self._places or payload is None:
            return mutant
        shared, process, vehicle = self._places[key]
        if key == RECEIVE.key(self._run, vehicle):
            return Mutant(shared, self._delivery(payload), attachment)
        stranger = self._random.choice([0, max(process.vehicles) + 1, 2**32 - 1])
        bundle = pack([(vehicle, payload)])
        twice = pack([(vehicle, payload), (vehicle, payload)])
        made = self._random.choice(
            [bundle] * 6
            + [
                twice,
                pack([(vehicle, payload), (stranger, payload)]),
                pack([(vehicle, payload), (process.vehicles[0], b"")]),
                bundle[: self._random.randrange(len(bundle))],
                pb.Bundle(vehicle=process.vehicles, payload=[payload]).SerializeToString(),
                b"",
            ]
        )
        return mutant if self._random.random() < 0.2 else Mutant(shared, made, attachment)

    def _delivery(self, payload: bytes) -> bytes:
        """Return the mutant of a receive as a delivery to its vehicle alone, or cut."""
        try:
            receive = pb.Receive.FromString(payload)
        except DecodeError:
            return payload
        rows = min(len(receive.source), len(receive.arrived_ns), len(receive.beacon))
        made = Delivery(
            cycle=receive.cycle,
            vehicle=np.array([receive.vehicle]),
            time_ns=np.array([receive.time_ns]),
            ends=np.array([len(receive.source)]),
            arrived_ns=np.array(receive.arrived_ns, dtype=np.int64),
            beacon=np.arange(rows),
            source=np.array(receive.source, dtype=np.int64),
            beacons=list(receive.beacon),
        ).encode()
        return made if self._random.random() < 0.9 else made[: self._random.randrange(len(made))]
