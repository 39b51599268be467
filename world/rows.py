"""Rows of the log: one message per cycle, with a value per vehicle in each column."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import nan
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND, RADAR, TRUTH, Topic
from zenvoy.world.sensors import Readings

Floats = NDArray[np.float64]

_OF_LINK: Final = tuple(field.name for field in pb.LinkEstimate.DESCRIPTOR.fields)

_NO_LINK: Final = pb.LinkEstimate(
    gap=nan,
    speed=nan,
    gap_std=nan,
    speed_std=nan,
    predicted_gap=nan,
    predicted_speed=nan,
    measured_ns=-1,
)
_NO_COMMAND: Final = pb.Command(
    effective_ns=-1,
    acceleration=nan,
    ahead=_NO_LINK,
    behind=_NO_LINK,
    speed=nan,
    speed_std=nan,
    predicted_speed=nan,
    age_ns=-1,
)
"""What a row holds for a vehicle that sent no command: nothing known, nothing decided."""


class Decided(NamedTuple):
    """What the vehicles decided in a cycle, at `time_ns`.

    commands: by vehicle; in real time some may be missing.
    """

    cycle: int
    time_ns: int
    vehicles: range
    commands: Mapping[int, pb.Command]

    @property
    def in_order(self) -> list[pb.Command]:
        """The commands of all vehicles, in order of vehicle."""
        return [self.commands.get(vehicle, _NO_COMMAND) for vehicle in self.vehicles]


def truth_row(
    cycle: int, time_ns: int, position: Floats, speed: Floats, acceleration: Floats
) -> Envelope:
    """Return the row of true positions (m), speeds (m/s) and mean accelerations (m/s²), (n,)."""
    message = pb.FleetTruth(
        cycle=cycle,
        time_ns=time_ns,
        position=position.tolist(),
        speed=speed.tolist(),
        acceleration=acceleration.tolist(),
    )
    return Envelope(TRUTH, 0, message.SerializeToString(), time_ns)


def radar_row(cycle: int, time_ns: int, readings: Readings, acceleration: Floats) -> Envelope:
    """Return the row of the readings of the vehicles, (n,); acceleration: m/s²."""
    message = pb.FleetRadar(
        cycle=cycle,
        time_ns=time_ns,
        gap=readings.gap.tolist(),
        relative_speed=readings.relative_speed.tolist(),
        position=readings.position.tolist(),
        speed=readings.speed.tolist(),
        acceleration=acceleration.tolist(),
    )
    return Envelope(RADAR, 0, message.SerializeToString(), time_ns)


def command_row(decided: Decided) -> Envelope:
    """Return the row of accelerations decided (m/s²) and the times at which they take effect."""
    commands = decided.in_order
    columns: dict[str, Iterable[float]] = {
        "acceleration": [command.acceleration for command in commands],
        "effective_ns": [command.effective_ns for command in commands],
    }
    return row_of(FLEET_COMMAND, decided.cycle, decided.time_ns, columns)


def estimate_row(decided: Decided, with_neighbours: bool, columns: Mapping[int, int]) -> Envelope:
    """Return the row of the estimates and predictions behind the commands.

    with_neighbours: whether to add the number of neighbours that counted. columns: how many values
    each law logs, by mode.
    """
    commands = decided.in_order
    values: dict[str, Iterable[float]] = {
        name: [getattr(command, name) for command in commands]
        for name in ("mode", "age_ns", "speed", "speed_std", "predicted_speed")
    }
    for side in ("ahead", "behind"):
        links = [getattr(command, side) for command in commands]
        values |= {f"{side}_{name}": [getattr(link, name) for link in links] for name in _OF_LINK}
    if with_neighbours:
        values["neighbours"] = [command.neighbours for command in commands]
    values["logged"] = _logged(commands, columns)
    return row_of(ESTIMATE, decided.cycle, decided.time_ns, values)


def row_of(
    topic: Topic[Any], cycle: int, time_ns: int, columns: Mapping[str, Iterable[float]]
) -> Envelope:
    """Return the message of a topic with these columns, each with a value per vehicle."""
    message = topic.message(cycle=cycle, time_ns=time_ns, **columns)
    return Envelope(topic, 0, message.SerializeToString(), time_ns)


def _logged(commands: Sequence[pb.Command], columns: Mapping[int, int]) -> Iterator[float]:
    """Yield the values of laws column by column, one per vehicle; NaN under another law."""
    for mode, count in columns.items():
        for index in range(count):
            for command in commands:
                has = command.mode == mode and index < len(command.logged)
                yield command.logged[index] if has else nan
