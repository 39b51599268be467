"""The vehicles that send a beacon in a cycle, and the sequence numbers of the beacons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.scenarios import Scenario, Settings
from zenvoy.vehicles.arrays.rows import Bools, Ints
from zenvoy.vehicles.beaconing import first_beacon

RULES: Final = ("every-cycle", "every-nth")
"""The rules that arrays run. The rule of CAMs would need another filter for each vehicle."""


class Beaconing:
    """Sends beacons as `vehicles.beaconing` does, for the vehicles with these settings.

    These are the vehicles of the whole fleet, once for each run, unless `vehicles` names them.
    """

    def __init__(
        self,
        scenario: Scenario,
        settings: Sequence[Settings],
        vehicles: Sequence[int] | None = None,
    ) -> None:
        each = vehicles or range(1, scenario.fleet.size + 1)
        first = [first_beacon(scenario, vehicle) for vehicle in each]
        self._n = scenario.cycles_per_beacon
        self._first = np.tile(np.array(first), len(settings) // len(first))
        self._beacons = np.array([one.beacons for one in settings])

    def at(self, cycle: int) -> tuple[Bools, Ints]:
        """Return which vehicles send in a cycle, and their sequence numbers."""
        number, rest = np.divmod(cycle - self._first, self._n)
        return self._beacons & (rest == 0) & (number >= 0), number
