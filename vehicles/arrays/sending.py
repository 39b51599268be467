"""Encodes the messages of vehicles that run as arrays, as `vehicles.messages` does one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from zenvoy.bus.flat_arrays import FlatTable
from zenvoy.laws import law_of
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beacons import Beacons
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.estimates import ESTIMATES, Estimates
from zenvoy.vehicles.arrays.rows import Bools, Ints
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.messages import (
    BEACON,
    BEACON_OF_FIRST,
    COMMAND,
    COMMANDED,
    LOGGED,
    NEIGHBOURS,
    PLANNED,
    PLANNED_FROM,
    silence,
)

_COMMAND: Final = FlatTable(COMMAND.pieces)
_NEIGHBOURS: Final = FlatTable(NEIGHBOURS.pieces)


class Form(NamedTuple):
    """What a beacon has besides its readings: a radar reading, entries of a plan, a command."""

    radar: bool
    entries: int
    command: bool


class Sending:
    """The messages of some vehicles of a scenario."""

    def __init__(self, scenario: Scenario, timing: Timing, vehicles: Sequence[int]) -> None:
        self._timing, self._delay_ns = timing, scenario.system_delay_ns
        self._vehicles = np.array(vehicles)
        self._radar = np.ones(len(vehicles), dtype=np.bool_)
        if scenario.ring_length_m is None:
            self._radar = self._vehicles != 1
        models = [roster(scenario)[vehicle - 1].models for vehicle in vehicles]
        counts = [any(law_of(model).needs.sides for model in each) for each in models]
        self._counting = [row for row, does in enumerate(counts) if does]

    def beacons(self, cycle: int, sent: Beacons, speaks: Bools, sequence: Ints) -> list[bytes]:
        """Return the beacon of each vehicle in a cycle, in order."""
        time_ns = cycle * self._timing.period_ns
        found = [b""] * len(self._vehicles)
        known = min(cycle + 1, self._timing.lag)
        entries = np.where(False if sent.plan.bare is None else sent.plan.bare, 1, known)
        for radar in (True, False):
            for count in {1, known}:
                rows = np.flatnonzero(speaks & (self._radar == radar) & (entries == count))
                if rows.size:
                    form = Form(radar, count, sent.command is not None)
                    payloads = self._of_form(form, rows, cycle, sent, sequence)
                    for row, payload in zip(rows.tolist(), payloads, strict=True):
                        found[row] = payload
        for row in np.flatnonzero(~speaks).tolist():
            found[row] = silence(cycle, time_ns, int(self._vehicles[row]))
        return found

    def _of_form(
        self, form: Form, rows: Ints, cycle: int, sent: Beacons, sequence: Ints
    ) -> list[bytes]:
        """Return the beacons of vehicles that all have one form."""
        timing = self._timing
        time_ns = cycle * timing.period_ns
        starts_ns, values = timing.starts_of(form.entries), sent.plan.values
        # At first, the commands before cycle 0 are no entries.
        plan = values[:1] if form.entries == 1 else values[timing.lag - form.entries :]
        columns: dict[str, Any] = {
            "sequence": sequence,
            "position": sent.position,
            "speed": sent.speed,
            "acceleration": sent.acceleration,
            "ahead_gap": sent.gap,
            "ahead_speed": sent.relative_speed,
            "commanded_acceleration": sent.command,
            "vehicle": self._vehicles,
            "planned_acceleration": np.array(plan).T,
        }
        some = {name: column[rows] for name, column in columns.items() if column is not None}
        from_ns = [time_ns + start_ns for start_ns in starts_ns]
        table = table_of(form)
        return table.encode(
            rows.size, cycle=cycle, time_ns=time_ns, planned_from_ns=from_ns, **some
        )

    def commands(self, cycle: int, decisions: Decisions, estimates: Estimates) -> list[bytes]:
        """Return the command of each vehicle in a cycle, in order."""
        decided_ns = cycle * self._timing.period_ns + self._timing.wait_ns
        count = len(self._vehicles)
        found = _COMMAND.encode(
            count,
            cycle=cycle,
            time_ns=decided_ns,
            vehicle=self._vehicles,
            effective_ns=decided_ns + self._delay_ns,
            acceleration=decisions.acceleration,
            **{name: estimates[name] for name in ESTIMATES},
        )
        if self._counting:
            also = _NEIGHBOURS.encode(count, neighbours=decisions.neighbours)
            for row in self._counting:
                found[row] += also[row]
        for row, logged in _logged(decisions):
            found[row] += logged
        return found


@cache
def table_of(form: Form) -> FlatTable:
    """Return the table of beacons of a form."""
    pieces = [*(BEACON if form.radar else BEACON_OF_FIRST).pieces]
    pieces += [PLANNED_FROM.piece(form.entries), PLANNED.piece(form.entries)]
    return FlatTable([*pieces, *(COMMANDED.pieces if form.command else ())])


def _logged(decisions: Decisions) -> Iterator[tuple[int, bytes]]:
    """Yield the vehicles whose laws log values, by row, with the end of their commands."""
    for mode, columns in decisions.logged.items():
        rows = np.flatnonzero(decisions.mode == mode)
        values = zip(*(column[rows].tolist() for column in columns), strict=True)
        for row, logged in zip(rows.tolist(), values, strict=True):
            yield row, LOGGED.encode(logged)
