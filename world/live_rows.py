"""Rows of the log about a cycle on the wall clock, of which anything may be missing. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import checks
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Envelope
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import REALTIME

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)
_REALTIME: Final = PackedCodec(pb.RealTime.DESCRIPTOR)
_NAN: Final = float("nan")
_NO_TIMING: Final = pb.Timing(sensed_ns=-1, decided_ns=-1)

Columns = dict[str, NDArray[Any]]


def no_command(cycle: int, time_ns: int) -> pb.Command:
    """What stands in the log where a vehicle has sent none: nothing known, nothing decided."""
    link = pb.LinkEstimate(
        gap=_NAN,
        speed=_NAN,
        gap_std=_NAN,
        speed_std=_NAN,
        predicted_gap=_NAN,
        predicted_speed=_NAN,
        measured_ns=-1,
    )
    return pb.Command(
        cycle=cycle,
        time_ns=time_ns,
        effective_ns=-1,
        acceleration=_NAN,
        ahead=link,
        behind=link,
        speed=_NAN,
        speed_std=_NAN,
        predicted_speed=_NAN,
        age_ns=-1,
    )


def frame_columns(payload: bytes) -> Columns:
    """Table of a serialized Frames, a row per frame and receiver; raises ValueError.

    Beside the rows, `busy_ratio` by vehicle; empty where it is not told, as is `hops`.
    """
    return {name: column for name, column in checks.frames_in(payload).items() if column.ndim}


def joined(tables: Sequence[Columns]) -> Columns:
    """One table of the frames of a cycle from any number of them, by source, then destination."""
    tables = [*tables, frame_columns(b"")]  # so that there is one in any case
    whole = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
    order = np.lexsort((whole["destination"], whole["source"]))
    busy_ratio = whole.pop("busy_ratio")[: len(tables[0]["busy_ratio"])]  # of the most frames
    return {name: column[order] if len(column) else column for name, column in whole.items()} | {
        "busy_ratio": busy_ratio
    }


def as_heard(frames: Columns, commands: Sequence[pb.Command]) -> Columns:
    """The frames of a cycle, as far as the `commands` of those who should have heard them say.

    They are the commands of the cycle in whose decisions the frames were to count. A frame of
    which its receiver does not tell there has missed the decision that it was due for: it is late.
    """
    heard = {
        (source, command.vehicle, arrived_ns)
        for command in commands
        for source, arrived_ns in zip(
            command.timing.source, command.timing.arrived_ns, strict=False
        )
    }
    outcome = frames["outcome"].copy()
    due = np.flatnonzero(outcome == pb.OUTCOME_DELIVERED)
    rows = (frames[name][due].tolist() for name in ("source", "destination", "arrived_ns"))
    missed = [row not in heard for row in zip(*rows, strict=True)]
    outcome[due[np.array(missed, dtype=np.bool_)]] = pb.OUTCOME_LATE
    return frames | {"outcome": outcome}


def links_of(cycle: int, time_ns: int, frames: Columns) -> pb.Links:
    """The frames of a cycle as the channel would tell of them."""
    payload = _FRAMES.encode(cycle=cycle, time_ns=time_ns, **frames)
    return pb.Links(cycle=cycle, time_ns=time_ns, frames=payload)


def realtime_row(
    *,
    cycle: int,
    time_ns: int,
    began_ns: int,
    deadline_ns: int,
    commands: Sequence[pb.Command],
    came_ns: Sequence[int],
) -> Envelope:
    """How a cycle kept to the clock; `commands` in order of vehicle, and when each came (-1)."""
    timings = [command.timing if command.HasField("timing") else _NO_TIMING for command in commands]
    heard = [len(timing.source) for timing in timings]
    payload = _REALTIME.encode(
        cycle=cycle,
        time_ns=time_ns,
        began_ns=began_ns,
        sensed_ns=[timing.sensed_ns for timing in timings],
        decided_ns=[timing.decided_ns for timing in timings],
        commanded_ns=came_ns,
        deadline_ns=deadline_ns,
        source=[source for timing in timings for source in timing.source],
        destination=np.repeat([command.vehicle for command in commands], heard),
        arrived_ns=[arrived for timing in timings for arrived in timing.arrived_ns],
        came_ns=[came for timing in timings for came in timing.came_ns],
    )
    return Envelope(REALTIME, 0, payload, time_ns)
