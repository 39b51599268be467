"""Frames without meaning that faulty transmitters send.

Each babbling transmitter counts as a further station at the place of its vehicle, with a queue of
frames. It senses the medium as others do, and also the beacons of its own vehicle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.csma import Hearing
from zenvoy.scenarios import Scenario, TransmitterBabbling, faults_of

Ints = NDArray[np.int64]


class Babble(NamedTuple):
    """Frames without meaning: the index of the vehicle that sends each, and its start, ns."""

    vehicle_index: Ints
    start_ns: Ints


NO_BABBLE = Babble(np.zeros(0, np.int64), np.zeros(0, np.int64))


class Babblers:
    """The babbling transmitters of a scenario, as stations after those of the `size` vehicles."""

    def __init__(self, scenario: Scenario) -> None:
        self._all = [
            (fault, vehicle - 1)
            for _, fault, vehicles in faults_of(scenario, TransmitterBabbling)
            for vehicle in vehicles
        ]
        self._size = scenario.fleet.size
        self.vehicle_index: Ints = np.array([index for _, index in self._all], np.int64)
        """The index of each station's vehicle."""

    def __len__(self) -> int:
        return len(self._all)

    def frames(self, sent_ns: int) -> Ints:
        """Return how many frames each station has to send in the cycle that starts then."""
        return np.array(
            [fault.frames_per_cycle if fault.in_force(sent_ns) else 0 for fault, _ in self._all],
            np.int64,
        )

    def heard(self, hearing: Hearing) -> Hearing:
        """Return which stations sense which, with those that babble.

        Stations at one place sense each other, and what one of them senses the other does too.
        """
        first, stations = hearing
        sensing = [stations[first[i] : first[i + 1]] for i in range(self._size)]
        at = {
            i: self._size + np.flatnonzero(self.vehicle_index == i)
            for i in set(self.vehicle_index.tolist())
        }
        none = np.zeros(0, np.int64)
        lists = []
        for station in range(self._size + len(self)):
            own = station if station < self._size else int(self.vehicle_index[station - self._size])
            near = np.concatenate([sensing[own], [own]])
            more = np.concatenate([none, *(at[i] for i in near.tolist() if i in at)])
            everyone = np.concatenate([near, more]).astype(np.int64)
            lists.append(everyone[everyone != station])
        bounds = np.cumsum([0, *(len(one) for one in lists)])
        return Hearing(bounds, np.concatenate(lists))
