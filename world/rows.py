"""Rows of the log: one message per cycle, with a value per vehicle in each column."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND, RADAR, TRUTH, Topic
from zenvoy.world.commands import FleetCommands
from zenvoy.world.sensors import Readings

Floats = NDArray[np.float64]

_ESTIMATES: Final = tuple(
    field.name
    for field in pb.FleetEstimate.DESCRIPTOR.fields
    if field.name not in {"cycle", "time_ns", "neighbours", "logged"}
)


class Decided(NamedTuple):
    """What the vehicles decided in a cycle, at `time_ns`; in real time, commands may be missing."""

    cycle: int
    time_ns: int
    commands: FleetCommands


def truth_row(
    cycle: int, time_ns: int, position: Floats, speed: Floats, acceleration: Floats
) -> Envelope:
    """Return the row of true positions (m), speeds (m/s) and mean accelerations (m/s²), (n,)."""
    columns = {"position": position, "speed": speed, "acceleration": acceleration}
    return row_of(TRUTH, cycle, time_ns, columns)


def radar_row(cycle: int, time_ns: int, readings: Readings, acceleration: Floats) -> Envelope:
    """Return the row of the readings of the vehicles, (n,); acceleration: m/s²."""
    columns = {
        "gap": readings.gap,
        "relative_speed": readings.relative_speed,
        "position": readings.position,
        "speed": readings.speed,
        "acceleration": acceleration,
    }
    return row_of(RADAR, cycle, time_ns, columns)


def command_row(decided: Decided) -> Envelope:
    """Return the row of accelerations decided (m/s²) and the times at which they take effect."""
    rows = decided.commands.rows
    columns = {name: rows[name] for name in ("acceleration", "effective_ns")}
    return row_of(FLEET_COMMAND, decided.cycle, decided.time_ns, columns)


def estimate_row(decided: Decided, with_neighbours: bool, columns: Mapping[int, int]) -> Envelope:
    """Return the row of the estimates and predictions behind the commands.

    with_neighbours: whether to add the number of neighbours that counted. columns: how many values
    each law logs, by mode.
    """
    rows = decided.commands.rows
    names = (*_ESTIMATES, "neighbours") if with_neighbours else _ESTIMATES
    values: dict[str, ArrayLike] = {name: rows[name] for name in names}
    values["logged"] = _logged(decided.commands, columns)
    return row_of(ESTIMATE, decided.cycle, decided.time_ns, values)


def row_of(
    topic: Topic[Any], cycle: int, time_ns: int, columns: Mapping[str, ArrayLike]
) -> Envelope:
    """Return the message of a topic with these columns, each with a value per vehicle.

    Its bytes are those that protobuf writes: fields in order, without times that are 0.
    """
    codec = _codec_of(topic)
    assert columns.keys() <= codec.fields().keys(), "a column that the message does not have"
    times = {"cycle": cycle, "time_ns": time_ns}
    values: dict[str, ArrayLike] = {name: value for name, value in times.items() if value}
    values |= {name: columns[name] for name in codec.fields() if name in columns}
    return Envelope(topic, 0, codec.encode(**values), time_ns)


@cache
def _codec_of(topic: Topic[Any]) -> PackedCodec:
    return PackedCodec(topic.message.DESCRIPTOR)


def _logged(commands: FleetCommands, columns: Mapping[int, int]) -> Floats:
    """Return the values of laws column by column, one per vehicle; NaN under another law."""
    mode = commands.rows["mode"]
    found = [np.zeros(0)]
    for its_mode, count in columns.items():
        values = commands.logged[:, :count].T
        found += list(np.where(mode == its_mode, values, np.nan))
    return np.concatenate(found)
