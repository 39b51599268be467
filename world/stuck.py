"""Actuators that are stuck: their vehicles keep an acceleration, whatever is commanded."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import ActuatorStuck, Scenario, faults_of

Floats = NDArray[np.float64]


class _Stuck:
    """A fault, the indices of its vehicles, and the accelerations that these keep, m/s²."""

    def __init__(self, fault: ActuatorStuck, vehicles: tuple[int, ...]) -> None:
        self.fault: Final = fault
        self.index: Final = np.array(vehicles, np.int64) - 1
        self.kept: Floats | float | None = fault.acceleration_mps2


class StuckActuators:
    """The stuck actuators of a scenario. Where several faults overlap, the later one counts."""

    def __init__(self, scenario: Scenario) -> None:
        self._all = [
            _Stuck(fault, vehicles) for _, fault, vehicles in faults_of(scenario, ActuatorStuck)
        ]

    def changes(self, after_ns: int, before_ns: int) -> set[int]:
        """Return the begins and ends of faults between the two times."""
        ends = (t for one in self._all for t in (one.fault.start_ns, one.fault.end_ns))
        return {t for t in ends if after_ns < t < before_ns}

    def ruled(self, time_ns: int) -> list[int]:
        """Return the indices of the vehicles whose actuators are stuck from `time_ns` on."""
        return [int(i) for one in self._all if one.fault.in_force(time_ns) for i in one.index]

    def applied(self, time_ns: int, a: Floats, given: Floats) -> Floats:
        """Return the accelerations from `time_ns` on (n,): `a`, but what is kept where stuck.

        given: what actuators give at `time_ns` if they are free, m/s². The fleet calls this at the
        begin of every fault, where the acceleration to keep is noted.
        """
        stuck = a.copy()
        for one in self._all:
            if one.fault.in_force(time_ns):
                if one.kept is None:
                    one.kept = given[one.index]
                stuck[one.index] = one.kept
        return stuck
