"""Encodes the messages of a vehicle, its beacon and its command, with each field by name."""

from __future__ import annotations

from math import nan
from typing import Final, NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.flat import ColumnEncoder, FlatEncoder, alone
from zenvoy.laws import Relative
from zenvoy.vehicles.decision import Decision, Predicted
from zenvoy.vehicles.knowledge import Knowledge
from zenvoy.vehicles.received import Report
from zenvoy.vehicles.shared_links import LinkEstimate

_NOT_FLAT: Final = (
    "planned_from_ns",
    "planned_acceleration",
    "silent",
    "commanded_acceleration",
    "odometer",
    "offset",
)
BEACON: Final = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=_NOT_FLAT)
BEACON_OF_FIRST: Final = FlatEncoder(pb.Beacon.DESCRIPTOR, leave_out=("ahead", *_NOT_FLAT))
PLANNED_FROM: Final = ColumnEncoder(pb.Beacon.DESCRIPTOR, "planned_from_ns")
PLANNED: Final = ColumnEncoder(pb.Beacon.DESCRIPTOR, "planned_acceleration")
COMMAND: Final = FlatEncoder(pb.Command.DESCRIPTOR, leave_out=("neighbours", "timing", "logged"))
NEIGHBOURS: Final = alone(pb.Command.DESCRIPTOR, "neighbours")
COMMANDED: Final = alone(pb.Beacon.DESCRIPTOR, "commanded_acceleration")
_ODOMETER: Final = alone(pb.Beacon.DESCRIPTOR, "odometer")
_OFFSET: Final = alone(pb.Beacon.DESCRIPTOR, "offset")
LOGGED: Final = ColumnEncoder(pb.Command.DESCRIPTOR, "logged")
_NOT_ESTIMATED: Final = Relative(nan, nan)


def silence(cycle: int, time_ns: int, vehicle: int) -> bytes:
    """Return a beacon that says that nothing goes on the air in a cycle."""
    beacon = pb.Beacon(cycle=cycle, time_ns=time_ns, vehicle=vehicle, silent=True)
    return beacon.SerializeToString()


def beacon(
    sense: pb.Sense, radar: Relative | None, sequence: int, plan: tuple[list[int], list[float]]
) -> bytes:
    """Return a beacon with the readings of a sense and the accelerations that the vehicle expects.

    radar: the radar reading in the sense; None for the first vehicle. plan: times (ns), and the
    acceleration from each of them on (m/s²).
    """
    # The fields are written twice, because passing them as a mapping takes half as long again.
    if radar is None:
        head = BEACON_OF_FIRST.encode(
            cycle=sense.cycle,
            time_ns=sense.time_ns,
            vehicle=sense.vehicle,
            sequence=sequence,
            position=sense.position,
            speed=sense.speed,
            acceleration=sense.acceleration,
        )
    else:
        head = BEACON.encode(
            cycle=sense.cycle,
            time_ns=sense.time_ns,
            vehicle=sense.vehicle,
            sequence=sequence,
            position=sense.position,
            speed=sense.speed,
            acceleration=sense.acceleration,
            ahead_gap=radar.p,
            ahead_speed=radar.v,
        )
    planned_from_ns, planned = plan
    return head + PLANNED_FROM.encode(planned_from_ns) + PLANNED.encode(planned)


def reported(command_mps2: float) -> bytes:
    """Return the newest command as the end of a beacon."""
    return COMMANDED.encode(commanded_acceleration=command_mps2)


def shared(report: Report) -> bytes:
    """Return what a beacon says for laws that share links, as its end."""
    odometer, offset = report.odometer, report.offset
    encoded = _ODOMETER.encode(
        odometer_distance=odometer.p, odometer_speed=odometer.v, odometer_since_ns=report.since_ns
    )
    if offset is None:
        return encoded
    return encoded + _OFFSET.encode(
        offset_gap=offset.p, offset_speed=offset.v, offset_ahead_since_ns=report.ahead_since_ns
    )


class Instants(NamedTuple):
    """The cycle of a command, when it is decided, and when it takes effect (ns)."""

    cycle: int
    decided_ns: int
    effective_ns: int


def command(
    vehicle: int,
    at: Instants,
    decision: Decision,
    known: Knowledge,
    predicted: Predicted | None,
    counts_neighbours: bool,
) -> bytes:
    """Return the command of a vehicle, with what it knew.

    predicted: None if it estimates nothing. counts_neighbours: whether to report how many
    neighbours counted.
    """
    link_ahead, link_behind = known.links
    ahead = _link(link_ahead, predicted.ahead if predicted else None)
    behind = _link(link_behind, predicted.behind if predicted else None)
    encoded = COMMAND.encode(
        cycle=at.cycle,
        time_ns=at.decided_ns,
        vehicle=vehicle,
        effective_ns=at.effective_ns,
        acceleration=decision.acceleration,
        mode=decision.mode,
        ahead_gap=ahead.estimate.p,
        ahead_speed=ahead.estimate.v,
        ahead_gap_std=ahead.gap_std,
        ahead_speed_std=ahead.speed_std,
        ahead_predicted_gap=ahead.predicted.p,
        ahead_predicted_speed=ahead.predicted.v,
        ahead_measured_ns=link_ahead.measured_ns,
        behind_gap=behind.estimate.p,
        behind_speed=behind.estimate.v,
        behind_gap_std=behind.gap_std,
        behind_speed_std=behind.speed_std,
        behind_predicted_gap=behind.predicted.p,
        behind_predicted_speed=behind.predicted.v,
        behind_measured_ns=link_behind.measured_ns,
        speed=known.speed.estimate if predicted else nan,
        speed_std=known.speed.std if predicted else nan,
        predicted_speed=predicted.speed if predicted else nan,
        age_ns=known.age_ns,
    )
    if counts_neighbours:
        encoded += NEIGHBOURS.encode(neighbours=decision.neighbours)
    return encoded + LOGGED.encode(decision.logged) if decision.logged else encoded


class _Link(NamedTuple):
    """What a command reports about a link; NaN if nothing is estimated."""

    estimate: Relative
    gap_std: float
    speed_std: float
    predicted: Relative


_NOTHING_KNOWN: Final = _Link(_NOT_ESTIMATED, nan, nan, _NOT_ESTIMATED)


def _link(state: LinkEstimate, predicted: Relative | None) -> _Link:
    estimate = state.estimate
    if estimate is None:
        return _NOTHING_KNOWN
    gap_std, speed_std = state.std or (nan, nan)
    return _Link(estimate, gap_std, speed_std, predicted or _NOT_ESTIMATED)
