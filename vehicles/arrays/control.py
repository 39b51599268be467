"""The law that each vehicle runs, over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from zenvoy.scenarios import Scenario, Settings
from zenvoy.scenarios.schema.roster import Phase
from zenvoy.vehicles.arrays.rows import Bools, Rows, chosen
from zenvoy.vehicles.control import FOLLOWING, controllers
from zenvoy.vehicles.decision import Controller


class Controllers:
    """The controllers over time of the vehicles with these settings, in order.

    leads is a mask of the vehicles that lead a platoon and so follow no platoon leader.
    """

    def __init__(self, scenario: Scenario, settings: Sequence[Settings], leads: Bools) -> None:
        phases: dict[tuple[Phase, ...], list[tuple[int, Controller]]] = {}
        for one in settings:
            if one.phases not in phases:
                phases[one.phases] = controllers(scenario, one)
        changes = {from_ns for each in phases.values() for from_ns, _ in each}
        self._changes_ns = sorted(changes)
        self._next = 0
        self._phases = phases
        self._settings = settings
        self._leads = leads
        self._in_force: list[tuple[Controller, Rows]] = []
        self.every = [controller for each in phases.values() for _, controller in each]
        """All controllers that are in force at some time."""

    def at(self, now_ns: int) -> list[tuple[Controller, Rows]]:
        """Return the controllers in force, and the vehicles of each; `now_ns` must not decrease."""
        changed = False
        while self._next < len(self._changes_ns) and self._changes_ns[self._next] <= now_ns:
            self._next += 1
            changed = True
        if changed:
            self._in_force = list(self._groups(now_ns))
        return self._in_force

    def _groups(self, now_ns: int) -> Iterator[tuple[Controller, Rows]]:
        current = {
            phases: [controller for from_ns, controller in each if from_ns <= now_ns][-1]
            for phases, each in self._phases.items()
        }
        each = np.empty(len(self._settings), dtype=object)
        for at, (one, leads) in enumerate(zip(self._settings, self._leads.tolist(), strict=True)):
            controller = current[one.phases]
            each[at] = FOLLOWING if controller.law.needs.leader and leads else controller
        numbers = np.array([id(controller) for controller in each])
        for number in dict.fromkeys(numbers.tolist()):
            rows = chosen(numbers == number)
            if rows is not None:
                yield each[rows][0], rows
