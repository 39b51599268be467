"""Rows of the log for a cycle in real time, of which any message may be missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.frame_table import FRAMES_CODEC, FrameTable, frame_table
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import REALTIME

_REALTIME: Final = PackedCodec(pb.RealTime.DESCRIPTOR)
_NO_TIMING: Final = pb.Timing(sensed_ns=-1, decided_ns=-1)


class Came(NamedTuple):
    """A command, and when it arrived (ns)."""

    command: pb.Command
    came_ns: int


def frames_of(
    cycle: int,
    time_ns: int,
    tables: Sequence[FrameTable],
    receivers: Sequence[pb.Command] | None,
    there: Sequence[int],
) -> bytes:
    """Return the frames of a cycle as they are logged: a serialized pb.Frames.

    tables: those that arrived for the cycle, each with other senders. A single table stays as it
    is; several are joined. receivers: the commands whose decisions should use the frames, as far as
    they arrived; None if the run ends before. A frame that its receiver does not report there
    missed that decision, and is logged as late. there: the vehicles that take part then; the
    scenario lets the others miss it.
    """
    table = tables[0] if len(tables) == 1 else _joined(cycle, time_ns, tables)
    if receivers is None:
        return table.payload
    missed = _missed(table.columns, receivers, there)
    if not len(missed):
        return table.payload
    outcome = table.columns["outcome"].copy()
    outcome[missed] = pb.OUTCOME_LATE
    return FRAMES_CODEC.with_column(table.payload, "outcome", outcome)


def _joined(cycle: int, time_ns: int, tables: Sequence[FrameTable]) -> FrameTable:
    """Join any number of tables into one, sorted by source, then destination."""
    at = {"cycle": cycle, "time_ns": time_ns}
    if not tables:
        return frame_table(FRAMES_CODEC.encode(**at))
    # Each table has its own busy ratios. Those of the first table cover the most frames.
    beside = {*at, "busy_ratio"}
    names = [name for name in tables[0].columns if name not in beside]
    whole = {name: np.concatenate([one.columns[name] for one in tables]) for name in names}
    order = np.lexsort((whole["destination"], whole["source"]))
    rows = {name: column[order] for name, column in whole.items() if len(column)}
    busy_ratio = tables[0].columns["busy_ratio"]
    return frame_table(FRAMES_CODEC.encode(**at, **rows, busy_ratio=busy_ratio))


def _missed(
    columns: Mapping[str, NDArray[Any]], receivers: Sequence[pb.Command], there: Sequence[int]
) -> NDArray[np.intp]:
    """Return the rows of frames that were delivered but that no receiver there reports."""
    delivered = columns["outcome"] == pb.OUTCOME_DELIVERED
    due = np.flatnonzero(delivered & np.isin(columns["destination"], there))
    timings = [command.timing for command in receivers]
    counts = np.array([len(timing.source) for timing in timings], dtype=np.int64)
    reported = (
        [source for timing in timings for source in timing.source],
        np.repeat(np.array([one.vehicle for one in receivers], dtype=np.int64), counts),
        [arrived_ns for timing in timings for arrived_ns in timing.arrived_ns],
    )
    names = ("source", "destination", "arrived_ns")
    ids = _ids(
        [
            np.concatenate([columns[name][due].astype(np.int64), np.array(values, dtype=np.int64)])
            for name, values in zip(names, reported, strict=True)
        ]
    )
    return due[~np.isin(ids[: len(due)], ids[len(due) :])]


def _ids(columns: Sequence[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Return a number for each row, equal for equal rows only."""
    found = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        values, at = np.unique(column, return_inverse=True)
        found = found * len(values) + at  # below the product of three counts, far from 2**63
    return found


def realtime_row(
    *,
    cycle: int,
    time_ns: int,
    began_ns: int,
    deadline_ns: int,
    vehicles: Sequence[int],
    commands: Mapping[int, Came],
) -> Envelope:
    """Return the row with the timing of a cycle.

    commands: those that arrived, by vehicle; the times of other vehicles are -1.
    """
    came = [commands.get(vehicle) for vehicle in vehicles]
    timings = [_NO_TIMING if one is None else _timing_of(one.command) for one in came]
    frames = [len(timing.source) for timing in timings]
    clocks: dict[str, list[int]] = {}
    if any(timing.clock_error_ns > 0 for timing in timings):
        errors = [-1 if one is _NO_TIMING else one.clock_error_ns for one in timings]
        offsets = [timing.clock_offset_ns for timing in timings]
        clocks = {"clock_offset_ns": offsets, "clock_error_ns": errors}
    payload = _REALTIME.encode(
        cycle=cycle,
        time_ns=time_ns,
        began_ns=began_ns,
        sensed_ns=[timing.sensed_ns for timing in timings],
        decided_ns=[timing.decided_ns for timing in timings],
        commanded_ns=[-1 if one is None else one.came_ns for one in came],
        deadline_ns=deadline_ns,
        source=[source for timing in timings for source in timing.source],
        destination=np.repeat(vehicles, frames),
        arrived_ns=[arrived_ns for timing in timings for arrived_ns in timing.arrived_ns],
        came_ns=[came_ns for timing in timings for came_ns in timing.came_ns],
        **clocks,
    )
    return Envelope(REALTIME, 0, payload, time_ns)


def _timing_of(command: pb.Command) -> pb.Timing:
    return command.timing if command.HasField("timing") else _NO_TIMING
