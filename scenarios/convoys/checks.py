"""Checks of recorded columns: clocks that jump back, gaps and speeds below zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.scenarios.convoys.convoy import Floats
from zenvoy.scenarios.convoys.errors import Faults
from zenvoy.values.wording import shown, trimmed

_STANDSTILL_MPS: Final = -0.5  # the error of a speed sensor at standstill is smaller


def check_clock(
    time_s: Floats, lines: Sequence[int], column: str, faults: Faults, whose: str = ""
) -> None:
    """Add a fault for each time (T,) that is missing, or not after the one before."""
    for index in np.flatnonzero(np.isnan(time_s)).tolist():
        faults.add(column, "missing", "a row has no time", lines[index])
    steps = np.diff(time_s)
    for index in (np.flatnonzero(steps == 0.0) + 1).tolist():
        text = f"two rows{whose} have the time {trimmed(float(time_s[index]))} s"
        faults.add(column, "twice", text, lines[index])
    for index in (np.flatnonzero(steps < 0.0) + 1).tolist():
        now, before = trimmed(float(time_s[index])), trimmed(float(time_s[index - 1]))
        text = f"the clock{whose} jumps back: {now} s comes after {before} s"
        faults.add(column, "clock", text, lines[index])


def check_gaps(gap: Floats, lines: Sequence[int], column: str, faults: Faults) -> None:
    """Add a fault for each gap (T,) below 0."""
    for index in np.flatnonzero(gap < 0.0).tolist():
        text = f"a gap of {gap[index]:.4g} m; allowed: at least 0, or --skip-negative-gaps"
        faults.add(column, "gap", text, lines[index])


def check_speeds(speed: Floats, lines: Sequence[int], column: str, faults: Faults) -> Floats:
    """Return speeds (T,) of which none is below 0, and add a fault for each that is far below.

    A speed slightly below 0 is an error of the sensor, and is taken to be 0.
    """
    for index in np.flatnonzero(speed < _STANDSTILL_MPS).tolist():
        text = f"a speed of {trimmed(float(speed[index]))} m/s; allowed: at least 0"
        faults.add(column, "speed", text, lines[index])
    return np.asarray(np.where(speed < 0.0, 0.0, speed))


def check_names(cars: Sequence[str], column: str, faults: Faults, line: int) -> None:
    """Add a fault for each name that two cars have."""
    for name in sorted({name for name in cars if cars.count(name) > 1}):
        text = f"{cars.count(name)} cars have the name {shown(name)}"
        faults.add(column, f"name {name}", text, line)
