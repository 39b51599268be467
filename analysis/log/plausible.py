"""What the tables of a log can hold. Numbers beyond that are damage, and no analysis bears them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import TRUTH

_LARGEST: Final = 1e9  # m, m/s, m/s²: no vehicle gets there
_LATEST_NS: Final = 1 << 60  # 36 years
_MODES: Final = set(pb.Mode.values()) - {pb.MODE_OWN}
_MOST_MODES: Final = 128
_OPTIONAL: Final = {"neighbours"}  # columns that not every run has
_OF_FRAMES: Final = ("destination", "sequence", "sent_ns", "arrived_ns", "latency_ns", "distance")
# No number of these is ever missing; of a command that never came in real time, all is.
_COMPLETE: Final = {TRUTH.log_name}
_OF_REALTIME: Final = (
    ("sensed_ns", "decided_ns", "commanded_ns"),
    ("source", "destination", "arrived_ns", "came_ns"),
)


def fleet_fault(topic: str, table: Table, vehicles: int) -> str | None:
    """What a table of the fleet, (rows, vehicles), cannot be; None where it can."""
    for name, column in table.items():
        if column.ndim == 2 and column.shape[1] != vehicles:
            if name in _OPTIONAL and not column.shape[1]:
                continue
            return f"{name} has {column.shape[1]} numbers in a message, the fleet {vehicles}"
        fault = _number_fault(name, column, complete=topic in _COMPLETE)
        if fault is None and name.endswith("_measured_ns"):
            fault = _reading_fault(name, column, table["time_ns"])
        if fault is not None:
            return fault
    return None


def _reading_fault(name: str, column: NDArray[Any], now_ns: NDArray[Any]) -> str | None:
    """Readings are of the past, or of no time (-1)."""
    if (column > now_ns[:, None]).any() or (column < -1).any():
        return f"{name} holds what is no time of a reading"
    return None


def frames_fault(table: Table, vehicles: int) -> str | None:
    """What the frames of a cycle cannot be; None where they can."""
    rows = len(table["source"])
    for name in (*_OF_FRAMES, "outcome"):
        if len(table[name]) != rows:
            return f"{name} has {len(table[name])} numbers in a message, source {rows}"
    for name, sizes in (("hops", {0, rows}), ("busy_ratio", {0, vehicles})):
        if len(table[name]) not in sizes:
            return f"{name} has {len(table[name])} numbers in a message"
    if not rows:
        return None
    for name in ("source", "destination"):
        if table[name].min() < 1 or table[name].max() > vehicles:
            return f"{name}: there is no such vehicle in a fleet of {vehicles}"
    return _first_number_fault(table)


def realtime_fault(table: Table, vehicles: int) -> str | None:
    """What a row of /realtime cannot be; None where it can."""
    fleet, frames = _OF_REALTIME
    for names, size in ((fleet, vehicles), (frames, len(table["source"]))):
        for name in names:
            if len(table[name]) != size:
                return f"{name} has {len(table[name])} numbers in a message, not {size}"
    return _first_number_fault(table)


def event_fault(event: pb.Event, vehicles: int) -> str | None:
    """What an event cannot be; None where it can."""
    if event.vehicle > vehicles:
        return f"vehicle {event.vehicle}: there is no such vehicle in a fleet of {vehicles}"
    if not 0 <= event.time_ns <= _LATEST_NS:
        return f"time_ns {event.time_ns} is no time of a run"
    return None


def _first_number_fault(table: Table) -> str | None:
    """The fault of the first column that has one, where no number may be missing."""
    faults = (_number_fault(name, column, complete=True) for name, column in table.items())
    return next((fault for fault in faults if fault is not None), None)


def _modes_exist(column: NDArray[Any]) -> bool:
    """Whether each mode is one of the list, or may be that of a law of the scenario's own."""
    own = (column >= pb.MODE_OWN) & (column < _MOST_MODES)
    return bool((own | (column <= max(_MODES))).all())


def _number_fault(name: str, column: NDArray[Any], complete: bool) -> str | None:
    if not column.size:
        return None
    if column.dtype.kind == "f":
        largest = np.nanmax(np.abs(column), initial=0.0)
        if largest > _LARGEST or (complete and np.isnan(column).any()):
            return f"{name} holds what is no number of a run"
    elif name == "mode" and not _modes_exist(column):
        return f"mode {column.max()} does not exist"
    elif name == "outcome" and column.max() > max(pb.Outcome.values()):
        return f"outcome {column.max()} does not exist"
    elif name.endswith("_ns") and (column.min() < -_LATEST_NS or column.max() > _LATEST_NS):
        return f"{name} holds what is no time of a run"
    return None
