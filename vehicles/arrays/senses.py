"""Reads the senses of vehicles that run as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.bundles import Parcel
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.flat_arrays import FlatTable
from zenvoy.bus.refusals import ABSURD, MISTIMED
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.vehicles import Senses


def _table(*left_out: str) -> FlatTable:
    return FlatTable(FlatEncoder(pb.Sense.DESCRIPTOR, left_out).pieces)


# In lock-step no sense has a wall time, and in real time each has.
_OF_MOST: Final = (_table("wall_start_ns"), _table())
_OF_FIRST: Final = (_table("ahead", "wall_start_ns"), _table("ahead"))
_COLUMNS: Final = {
    "position": "position",
    "speed": "speed",
    "acceleration": "acceleration",
    "ahead_gap": "gap",
    "ahead_speed": "relative_speed",
}


class Sensed(NamedTuple):
    """The senses of a cycle, and why they are refused, or None.

    wall_start_ns: the wall time of time 0; 0 in lock-step.
    """

    cycle: int
    fault: str | None
    senses: Senses
    time_ns: int
    wall_start_ns: int


class Sensing:
    """Reads the senses of some vehicles of a scenario."""

    def __init__(self, scenario: Scenario, vehicles: Sequence[int]) -> None:
        self._vehicles, self._period_ns = vehicles, scenario.period_ns
        sees = [scenario.ring_length_m is not None or vehicle != 1 for vehicle in vehicles]
        groups = (
            (_OF_MOST, [at for at, does in enumerate(sees) if does]),
            (_OF_FIRST, [at for at, does in enumerate(sees) if not does]),
        )
        self._groups = [(tables, rows) for tables, rows in groups if rows]

    def read(self, parcels: Sequence[Parcel]) -> Sensed:
        """Return the senses of all vehicles, each with a radar reading if anybody is ahead.

        Raises PayloadError if any is missing or has another form.
        """
        if [vehicle for vehicle, _ in parcels] != list(self._vehicles):
            raise PayloadError(f"senses of {len(parcels)} vehicles, not of {len(self._vehicles)}")
        found = Senses(*np.full((len(Senses._fields), len(parcels)), NAN))
        cycles, starts_ns, fault = set[int](), set[int](), None
        for tables, rows in self._groups:
            payloads = [parcels[row][1] for row in rows]
            read = tables[len(payloads[0]) == tables[1].size].decode(payloads)
            if read is None:
                raise PayloadError("a sense of another form")
            if read["vehicle"].tolist() != [self._vehicles[row] for row in rows]:
                raise PayloadError("a sense of another vehicle")
            if (read["time_ns"] != read["cycle"].astype(np.int64) * self._period_ns).any():
                fault = MISTIMED
            cycles.update(read["cycle"].tolist())
            names = set(read.dtype.names or ())
            starts_ns.update(read["wall_start_ns"].tolist() if "wall_start_ns" in names else (0,))
            for name in _COLUMNS.keys() & names:
                getattr(found, _COLUMNS[name])[rows] = read[name]
                if not np.isfinite(read[name]).all():
                    fault = ABSURD
        if len(cycles) != 1 or len(starts_ns) != 1:
            raise PayloadError("senses of several cycles or runs")
        cycle = cycles.pop()
        return Sensed(cycle, fault, found, cycle * self._period_ns, starts_ns.pop())
