"""Rows of the log for a cycle in real time, of which any message may be missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.frame_table import FRAMES_CODEC, FrameTable, frame_table
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import REALTIME
from zenvoy.world.timings import Rows, Timings

_REALTIME: Final = PackedCodec(pb.RealTime.DESCRIPTOR)
_LARGEST_ID: Final = 2**62


def frames_of(
    cycle: int,
    time_ns: int,
    tables: Sequence[FrameTable],
    receivers: Timings | None,
    there: Sequence[int],
) -> bytes:
    """Return the frames of a cycle as they are logged: a serialized pb.Frames.

    tables: those that arrived for the cycle, each with other senders. A single table stays as it
    is; several are joined. receivers: the timing of the commands whose decisions should use the
    frames, as far as they arrived; None if the run ends before. A frame that its receiver does not
    report there missed that decision, and is logged as late. there: the vehicles that take part
    then; the scenario lets the others miss it.
    """
    table = tables[0] if len(tables) == 1 else _joined(cycle, time_ns, tables)
    if receivers is None:
        return table.payload
    missed = _missed(table.columns, receivers.frames, there)
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
    columns: Mapping[str, NDArray[Any]], reported: Rows, there: Sequence[int]
) -> NDArray[np.intp]:
    """Return the rows of frames that were delivered but that no receiver there reports."""
    delivered = columns["outcome"] == pb.OUTCOME_DELIVERED
    due = np.flatnonzero(delivered & np.isin(columns["destination"], there))
    ids = _ids(
        [
            np.concatenate([columns[name][due].astype(np.int64), reported[name]])
            for name in ("source", "destination", "arrived_ns")
        ]
    )
    return due[~_are_among(ids[: len(due)], ids[len(due) :])]


def _are_among(ids: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which numbers are among others. For 50,000 of each, np.isin takes 8 times as long."""
    known = np.sort(others)
    at = np.searchsorted(known, ids)
    found = np.zeros(len(ids), dtype=np.bool_)
    inside = at < len(known)
    found[inside] = known[at[inside]] == ids[inside]
    return found


def _ids(columns: Sequence[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Return a number for each row, equal for equal rows only."""
    found, most = np.zeros(len(columns[0]), dtype=np.int64), 1
    for column in columns if len(found) else ():
        low, high = int(column.min()), int(column.max())
        values = high - low + 1
        if most * values > _LARGEST_ID:  # they are far apart: count only those that there are
            distinct, at = np.unique(column, return_inverse=True)
            values = len(distinct)
        else:
            at = column - low
        found, most = found * values + at, most * values
    return found


def realtime_row(
    *, cycle: int, time_ns: int, began_ns: int, deadline_ns: int, timings: Timings
) -> Envelope:
    """Return the row with the timing of a cycle."""
    times, frames = timings.times, timings.frames
    clocks = {}
    if (times["clock_error_ns"] > 0).any():
        clocks = {name: times[name] for name in ("clock_offset_ns", "clock_error_ns")}
    payload = _REALTIME.encode(
        cycle=cycle,
        time_ns=time_ns,
        began_ns=began_ns,
        sensed_ns=times["sensed_ns"],
        decided_ns=times["decided_ns"],
        commanded_ns=timings.commanded_ns,
        deadline_ns=deadline_ns,
        source=frames["source"],
        destination=frames["destination"],
        arrived_ns=frames["arrived_ns"],
        came_ns=frames["came_ns"],
        **clocks,
    )
    return Envelope(REALTIME, 0, payload, time_ns)
