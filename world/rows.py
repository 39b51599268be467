"""From the commands of a cycle to rows of the log, in order of vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import nan
from typing import Final, NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND

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
"""What a row says of a vehicle that has sent no command: nothing known, nothing decided."""


class Decided(NamedTuple):
    """What the vehicles have decided in a cycle, at `time_ns`.

    commands: by vehicle. One may be missing in real time.
    """

    cycle: int
    time_ns: int
    vehicles: range
    commands: Mapping[int, pb.Command]

    @property
    def in_order(self) -> list[pb.Command]:
        """A command for each vehicle, in order of vehicle."""
        return [self.commands.get(vehicle, _NO_COMMAND) for vehicle in self.vehicles]


def command_row(decided: Decided) -> Envelope:
    """Accelerations decided (m/s²) and when they take effect."""
    commands = decided.in_order
    message = pb.FleetCommand(
        cycle=decided.cycle,
        time_ns=decided.time_ns,
        acceleration=[command.acceleration for command in commands],
        effective_ns=[command.effective_ns for command in commands],
    )
    return Envelope(FLEET_COMMAND, 0, message.SerializeToString(), decided.time_ns)


def estimate_row(decided: Decided, with_neighbours: bool, columns: Mapping[int, int]) -> Envelope:
    """Estimates and predictions behind the commands; `with_neighbours`: and how many counted.

    columns: how many values the laws of the scenario's own log, by mode.
    """
    commands = decided.in_order
    ahead = [command.ahead for command in commands]
    behind = [command.behind for command in commands]
    message = pb.FleetEstimate(
        cycle=decided.cycle,
        time_ns=decided.time_ns,
        mode=[command.mode for command in commands],
        age_ns=[command.age_ns for command in commands],
        speed=[command.speed for command in commands],
        speed_std=[command.speed_std for command in commands],
        predicted_speed=[command.predicted_speed for command in commands],
        ahead_gap=[link.gap for link in ahead],
        ahead_speed=[link.speed for link in ahead],
        ahead_gap_std=[link.gap_std for link in ahead],
        ahead_speed_std=[link.speed_std for link in ahead],
        ahead_predicted_gap=[link.predicted_gap for link in ahead],
        ahead_predicted_speed=[link.predicted_speed for link in ahead],
        ahead_measured_ns=[link.measured_ns for link in ahead],
        behind_gap=[link.gap for link in behind],
        behind_speed=[link.speed for link in behind],
        behind_gap_std=[link.gap_std for link in behind],
        behind_speed_std=[link.speed_std for link in behind],
        behind_predicted_gap=[link.predicted_gap for link in behind],
        behind_predicted_speed=[link.predicted_speed for link in behind],
        behind_measured_ns=[link.measured_ns for link in behind],
        neighbours=[command.neighbours for command in commands] if with_neighbours else (),
        logged=_logged(commands, columns),
    )
    return Envelope(ESTIMATE, 0, message.SerializeToString(), decided.time_ns)


def _logged(commands: Sequence[pb.Command], columns: Mapping[int, int]) -> Iterator[float]:
    """Column by column, a number per vehicle; NaN where it is under another law."""
    for mode, count in columns.items():
        for index in range(count):
            for command in commands:
                has = command.mode == mode and index < len(command.logged)
                yield command.logged[index] if has else nan
