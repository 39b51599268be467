"""The vehicles that send a beacon in a cycle, and the sequence numbers of the beacons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.scenarios import Scenario, Settings
from zenvoy.vehicles.arrays.rows import Bools, Ints

RULES: Final = ("every-cycle", "every-nth")
"""The rules that arrays run. The rule of CAMs needs a filter of its own for each vehicle."""


class Beaconing:
    """Sends beacons as `vehicles.beaconing` does, for the vehicles with these settings."""

    def __init__(self, scenario: Scenario, settings: Sequence[Settings]) -> None:
        n = scenario.beacons.every if scenario.beacons.rule == "every-nth" else 1
        index = np.arange(len(settings)) % scenario.fleet.size
        self._n, self._first = n, index % n
        self._beacons = np.array([one.beacons for one in settings])

    def at(self, cycle: int) -> tuple[Bools, Ints]:
        """Return which vehicles send in a cycle, and their sequence numbers."""
        number, rest = np.divmod(cycle - self._first, self._n)
        return self._beacons & (rest == 0) & (number >= 0), number
