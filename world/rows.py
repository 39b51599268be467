"""From the commands of a cycle to rows of the log, in order of vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import nan

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND


def command_row(commands: Sequence[pb.Command]) -> Envelope:
    """Accelerations decided (m/s²) and when they take effect."""
    first = commands[0]
    message = pb.FleetCommand(
        cycle=first.cycle,
        time_ns=first.time_ns,
        acceleration=[command.acceleration for command in commands],
        effective_ns=[command.effective_ns for command in commands],
    )
    return Envelope(FLEET_COMMAND, 0, message.SerializeToString(), first.time_ns)


def estimate_row(
    commands: Sequence[pb.Command], with_neighbours: bool, columns: Mapping[int, int]
) -> Envelope:
    """Estimates and predictions behind the commands; `with_neighbours`: and how many counted.

    columns: how many values the laws of the scenario's own log, by mode.
    """
    first = commands[0]
    ahead = [command.ahead for command in commands]
    behind = [command.behind for command in commands]
    message = pb.FleetEstimate(
        cycle=first.cycle,
        time_ns=first.time_ns,
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
    return Envelope(ESTIMATE, 0, message.SerializeToString(), first.time_ns)


def _logged(commands: Sequence[pb.Command], columns: Mapping[int, int]) -> Iterator[float]:
    """Column by column, a number per vehicle; NaN where it is under another law."""
    for mode, count in columns.items():
        for index in range(count):
            for command in commands:
                has = command.mode == mode and index < len(command.logged)
                yield command.logged[index] if has else nan
