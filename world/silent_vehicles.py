"""Vehicles that send no command for too long, which only real time allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario, attendance
from zenvoy.world.commands import Rows

Ints = NDArray[np.int64]


class SilentVehicles:
    """A vehicle is silent `beacon_age_limit_ms` after the effect of its newest command.

    Without any command, this time counts from 0.

    What a vehicle does whose process the scenario has killed or frozen is up to the scenario.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._period_ns, self._hold_ns = scenario.period_ns, scenario.beacon_age_limit_ns
        self._attendance = attendance(scenario)
        self._acts_ns = np.zeros(scenario.fleet.size, dtype=np.int64)  # effect of newest command
        self._silent = np.zeros(scenario.fleet.size, dtype=np.bool_)

    def heard(self, rows: Rows, came_ns: Ints) -> list[pb.Event]:
        """Take in commands, rows of `ROW` (k,), and their arrivals, ns; return who was silent."""
        at = rows["vehicle"].astype(np.intp) - 1
        self._acts_ns[at] = rows["effective_ns"]
        again = np.flatnonzero(self._silent[at])
        self._silent[at] = False
        return [
            self._event(pb.EVENT_SILENT_END, int(at[one]), int(came_ns[one]))
            for one in again.tolist()
        ]

    def falling_silent(self, until_ns: int) -> Sequence[pb.Event]:
        """Note who falls silent up to an instant, and return when each did."""
        for vehicle in self._attendance.absences:
            if not self._attendance.takes_part(vehicle, until_ns // self._period_ns):
                self._acts_ns[vehicle - 1] = until_ns
        ends_ns = self._acts_ns + self._hold_ns
        found = np.flatnonzero((ends_ns <= until_ns) & ~self._silent)
        self._silent[found] = True
        return [
            self._event(pb.EVENT_SILENT, index, int(ends_ns[index])) for index in found.tolist()
        ]

    def _event(self, kind: pb.EventKind.ValueType, index: int, time_ns: int) -> pb.Event:
        cycle = time_ns // self._period_ns
        return pb.Event(cycle=cycle, time_ns=time_ns, kind=kind, vehicle=index + 1)
