"""Rejects numbers in a log that no run can produce. They are damage, and would break the analysis.

Each function returns a sentence on the first fault of a table, or None where there is none.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.log.columns import Table
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.frame_table import FRAME_COLUMNS
from zenvoy.bus.topics import TRUTH

_LARGEST_VALUE: Final = 1e9  # m, m/s, m/s²: no vehicle reaches it
_LATEST_NS: Final = 1 << 60  # 36 years
_MODES: Final = set(pb.Mode.values()) - {pb.MODE_OWN}
_MOST_MODES: Final = 128
_OPTIONAL: Final = {"neighbours"}  # columns that not every run has
# Topics in which no number is ever missing. In real time a command that never arrived is all NaN.
_COMPLETE: Final = {TRUTH.log_name}
# Columns of /realtime with a number per vehicle, and with a number per frame.
_REALTIME_COLUMNS: Final = (
    ("sensed_ns", "decided_ns", "commanded_ns"),
    ("source", "destination", "arrived_ns", "came_ns"),
)


def fleet_fault(topic: str, table: Table, vehicles: int) -> str | None:
    """Return what is wrong with a table of the fleet, (rows, vehicles)."""
    for name, column in table.items():
        if column.ndim == 2 and column.shape[1] != vehicles:
            if name in _OPTIONAL and not column.shape[1]:
                continue
            return f"{name} has {column.shape[1]} numbers in a message, not {vehicles}"
        fault = _number_fault(name, column, complete=topic in _COMPLETE)
        if fault is None and name.endswith("_measured_ns"):
            fault = _reading_fault(name, column, table["time_ns"])
        if fault is not None:
            return fault
    return None


def _reading_fault(name: str, column: NDArray[Any], now_ns: NDArray[Any]) -> str | None:
    """Return what is wrong with times of readings: each must be past, or -1 for none."""
    if (column > now_ns[:, None]).any() or (column < -1).any():
        return f"{name} holds a number that cannot be the time of a reading"
    return None


def frames_fault(table: Table, vehicles: int) -> str | None:
    """Return what is wrong with the frames of a cycle."""
    rows = len(table["source"])
    for name in FRAME_COLUMNS:
        if len(table[name]) != rows:
            return f"{name} has {len(table[name])} numbers in a message, but source has {rows}"
    for name, sizes in (("hops", {0, rows}), ("busy_ratio", {0, vehicles})):
        if len(table[name]) not in sizes:
            return f"{name} has {len(table[name])} numbers in a message, not {max(sizes)}"
    if not rows:
        return None
    for name in ("source", "destination"):
        if table[name].min() < 1 or table[name].max() > vehicles:
            return f"{name} holds a vehicle that is not in the fleet of {vehicles}"
    return _first_number_fault(table)


def realtime_fault(table: Table, vehicles: int) -> str | None:
    """Return what is wrong with a row of /realtime."""
    fleet, frames = _REALTIME_COLUMNS
    for names, size in ((fleet, vehicles), (frames, len(table["source"]))):
        for name in names:
            if len(table[name]) != size:
                return f"{name} has {len(table[name])} numbers in a message, not {size}"
    return _first_number_fault(table)


def event_fault(event: pb.Event, vehicles: int) -> str | None:
    """Return what is wrong with an event."""
    if event.vehicle > vehicles:
        return f"vehicle {event.vehicle} is not in the fleet of {vehicles}"
    if not 0 <= event.time_ns <= _LATEST_NS:
        return f"time_ns {event.time_ns} cannot be a time of a run"
    return None


def _first_number_fault(table: Table) -> str | None:
    """Return the fault of the first column that has one; no number may be missing."""
    faults = (_number_fault(name, column, complete=True) for name, column in table.items())
    return next((fault for fault in faults if fault is not None), None)


def _modes_exist(column: NDArray[Any]) -> bool:
    """Return whether each mode is known, or may belong to a law that is not in the library."""
    own = (column >= pb.MODE_OWN) & (column < _MOST_MODES)
    return bool((own | (column <= max(_MODES))).all())


def _number_fault(name: str, column: NDArray[Any], complete: bool) -> str | None:
    if not column.size:
        return None
    if column.dtype.kind == "f":
        largest = np.nanmax(np.abs(column), initial=0.0)
        if largest > _LARGEST_VALUE or (complete and np.isnan(column).any()):
            return f"{name} holds a number that no run can produce"
    elif name == "mode" and not _modes_exist(column):
        return f"mode {column.max()} does not exist"
    elif name == "outcome" and column.max() > max(pb.Outcome.values()):
        return f"outcome {column.max()} does not exist"
    elif name.endswith("_ns") and (column.min() < -_LATEST_NS or column.max() > _LATEST_NS):
        return f"{name} holds a number that cannot be a time of a run"
    return None
