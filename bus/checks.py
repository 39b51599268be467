"""Checks of messages against what their reader already knows, before they are used.

Each `fault_in_…` returns the reason to refuse a message, or None. It cannot tell who wrote the
message: a forged message that passes all checks looks like a real one.
"""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

import numpy as np
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.frame_table import FrameTable, frame_table
from zenvoy.bus.refusals import ABSURD, FOREIGN, MALFORMED, MISTIMED, RefusedError

_MODES: Final = frozenset(pb.Mode.values())
_MOST_MODES: Final = 128  # a varint of one byte
_OUTCOMES: Final = range(1, len(pb.Outcome.values()))


def fault_in_sense(sense: pb.Sense, vehicle: int, time_ns: int) -> str | None:
    """Check that a sense is for `vehicle` and from the start of its cycle, `time_ns`."""
    if sense.vehicle != vehicle:
        return FOREIGN
    if sense.time_ns != time_ns:
        return MISTIMED
    ahead = sense.ahead
    motion = sense.position + sense.speed + sense.acceleration + ahead.gap + ahead.speed
    return None if isfinite(motion) else ABSURD


def fault_in_beacon(beacon: pb.Beacon, vehicle: int, time_ns: int) -> str | None:
    """Check a beacon as `fault_in_sense` checks a sense, and also its plan and sequence number.

    A sequence number is at most the cycle, because no beacon rule sends more than once per cycle.
    Loss models step through all numbers, so a huge number would keep the channel busy.
    """
    if beacon.vehicle != vehicle:
        return FOREIGN
    if beacon.time_ns != time_ns:
        return MISTIMED
    planned = len(beacon.planned_acceleration)
    if len(beacon.planned_from_ns) != planned or bool(planned) == beacon.silent:
        return MALFORMED  # without this check, a sense would pass for a beacon
    return None if is_sane(beacon) and beacon.sequence <= beacon.cycle else ABSURD


def is_sane(beacon: pb.Beacon) -> bool:
    """Return whether all numbers of a beacon are finite."""
    ahead = beacon.ahead
    motion = beacon.acceleration + beacon.speed + beacon.position + ahead.gap + ahead.speed
    motion += beacon.commanded_acceleration
    if beacon.HasField("odometer"):
        motion += beacon.odometer.distance + beacon.odometer.speed
    if beacon.HasField("offset"):
        motion += beacon.offset.gap + beacon.offset.speed
    return isfinite(motion + sum(beacon.planned_acceleration))


def is_of(payload: bytes, vehicle: int) -> bool:
    """Return whether a payload is a beacon of that vehicle, whatever else it says."""
    try:
        return pb.Beacon.FromString(payload).vehicle == vehicle
    except DecodeError:
        return False


def fault_in_positions(positions: pb.Positions, size: int, time_ns: int) -> str | None:
    """Check that each vehicle of the fleet has a finite position, and that a loss is a share."""
    if positions.time_ns != time_ns:
        return MISTIMED
    if len(positions.position) != size:
        return MALFORMED
    is_share = 0.0 <= positions.loss_by_hand <= 1.0
    return None if is_share and isfinite(sum(positions.position)) else ABSURD


def fault_in_receive(receive: pb.Receive, vehicle: int, time_ns: int | None) -> str | None:
    """Check everything but the beacons inside; time_ns is None in real time, where any is valid."""
    if receive.vehicle != vehicle:
        return FOREIGN
    if time_ns is not None and receive.time_ns != time_ns:
        return MISTIMED
    rows = len(receive.source)
    in_step = len(receive.beacon) == rows and len(receive.arrived_ns) == rows
    return None if in_step else MALFORMED


def fault_in_command(
    command: pb.Command, vehicle: int, time_ns: int, effective_ns: int
) -> str | None:
    """Check that a command was decided at `time_ns` and takes effect at `effective_ns`."""
    if command.vehicle != vehicle:
        return FOREIGN
    if command.time_ns != time_ns or command.effective_ns != effective_ns:
        return MISTIMED
    return None if isfinite(command.acceleration) and _is_mode(command.mode) else ABSURD


def _is_mode(mode: int) -> bool:
    """Return whether a mode is one of pb.Mode, or that of one of the scenario's own laws."""
    return mode in _MODES or pb.MODE_OWN <= mode < _MOST_MODES


def are_modes(modes: NDArray[Any]) -> bool:
    """Return whether all numbers are modes of commands."""
    return all(_is_mode(mode) for mode in np.unique(modes).tolist())


def fault_in_timing(timing: pb.Timing, size: int) -> str | None:
    """Check the timing in a command: its columns match, and its frames come from the fleet."""
    source = timing.source[:]  # a list is faster
    rows = len(source)
    if len(timing.arrived_ns) != rows or len(timing.came_ns) != rows:
        return MALFORMED
    of_fleet = not rows or (min(source) >= 1 and max(source) <= size)
    return None if of_fleet and timing.clock_error_ns >= 0 else ABSURD


def table_of(links: pb.Links, size: int, time_ns: int) -> FrameTable:
    """Return the table of frames that the channel reports for the cycle that starts at `time_ns`.

    Raises RefusedError unless the table is well formed, has the times of that cycle, and is about a
    fleet of `size` vehicles.
    """
    if links.time_ns != time_ns:
        raise RefusedError(MISTIMED)
    payload = links.frames
    if not payload:  # protobuf would read a table of cycle 0 without frames
        raise RefusedError(MALFORMED)
    try:
        table = frame_table(payload)
    except ValueError as error:
        raise RefusedError(MALFORMED) from error
    columns = table.columns
    if columns["cycle"] != links.cycle or columns["time_ns"] != time_ns:
        raise RefusedError(MISTIMED)
    if len(columns["busy_ratio"]) not in {0, size}:
        raise RefusedError(MALFORMED)
    fleet = range(1, size + 1)
    of_fleet = _within(columns["source"], fleet) and _within(columns["destination"], fleet)
    if not (of_fleet and _within(columns["outcome"], _OUTCOMES)):
        raise RefusedError(ABSURD)
    return table


def _within(column: NDArray[Any], allowed: range) -> bool:
    return not len(column) or bool(
        np.min(column) >= allowed.start and np.max(column) < allowed.stop
    )
