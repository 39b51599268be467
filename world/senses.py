"""Encodes the senses of a cycle: the readings that the world sends to each vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.flat import FlatEncoder
from zenvoy.bus.flat_arrays import FlatTable
from zenvoy.bus.topics import SENSE
from zenvoy.world.sensors import Readings

Floats = NDArray[np.float64]

# The key says whether a vehicle is ahead, and whether the run is in real time.
_TABLES: Final = {
    (ahead, realtime): FlatTable(
        FlatEncoder(
            pb.Sense.DESCRIPTOR,
            (*(() if ahead else ("ahead",)), *(() if realtime else ("wall_start_ns",))),
        ).pieces
    )
    for ahead in (True, False)
    for realtime in (True, False)
}


def senses(
    cycle: int,
    time_ns: int,
    vehicles: Sequence[int],
    readings: Readings,
    acceleration: Floats,
    wall_start_ns: int,
) -> list[Envelope]:
    """Return the senses of some vehicles, in order.

    readings are those of all vehicles, as is acceleration, which each reads of itself, m/s²: (n,).
    A vehicle without a gap has none ahead. wall_start_ns is the wall time of time 0 in real time,
    else 0.
    """
    numbers = np.array(vehicles, dtype=np.int64)
    columns: dict[str, NDArray[Any]] = {
        "position": readings.position,
        "speed": readings.speed,
        "acceleration": acceleration,
        "ahead_gap": readings.gap,
        "ahead_speed": readings.relative_speed,
    }
    sees = ~np.isnan(readings.gap[numbers - 1])
    found = [b""] * len(numbers)
    for ahead in (True, False):
        rows = np.flatnonzero(sees == ahead)
        if not rows.size:
            continue
        its = {name: column[numbers[rows] - 1] for name, column in columns.items()}
        payloads = _TABLES[ahead, bool(wall_start_ns)].encode(
            rows.size,
            cycle=cycle,
            time_ns=time_ns,
            vehicle=numbers[rows],
            wall_start_ns=wall_start_ns,
            **its,
        )
        for row, payload in zip(rows.tolist(), payloads, strict=True):
            found[row] = payload
    pairs = zip(vehicles, found, strict=True)
    return [Envelope(SENSE, vehicle, payload) for vehicle, payload in pairs]
