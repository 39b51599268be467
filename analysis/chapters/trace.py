"""A speed trace in tables and a picture: how it is read, and what it asks of a vehicle."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.scenarios import Recording

Floats = NDArray[np.float64]
Row = tuple[Cell, ...]

_STANDS_MPS: Final = 0.1
_LATE_S: Final = 60.0  # a later first time is probably clock time, and not a wait
_NAMES: Final = {"\t": "tab", ";": ";", ",": ","}


def trace_section(read: Recording, limit_mps2: float) -> Section:
    """Return what was read, with the limit of commands; the recording has at least two points."""
    time_s, speed = np.array(read.points).T
    a = np.diff(speed) / np.diff(time_s)
    return Section(
        title="Trace",
        notes=tuple(_notes(read, a, limit_mps2)),
        sheets=(_reading(read), _motion(time_s, speed, a, limit_mps2)),
        pictures=(
            Picture(
                name="trace",
                caption=(
                    "Speed over time, and the acceleration from each point to the next. The dashed "
                    f"lines are the limits of commands, ±{limit_mps2:g} m/s². They do not apply to "
                    "the vehicle that follows the trace, but to the vehicles behind it."
                ),
                draw=lambda: _drawn(time_s, speed, a, limit_mps2),
            ),
        ),
    )


def _reading(read: Recording) -> Sheet:
    rows: list[Row] = [
        ("line of the header", read.grid.header_line),
        ("delimiter", _NAMES[read.grid.delimiter]),
        ("column of times", read.time_column),
        ("unit of times", read.time_unit),
        ("first time, as written", read.first_time),
        ("time 0", "first point" if read.from_first else "as in the file"),
        ("column of speeds", read.column),
        ("unit of speeds", read.unit),
        ("points", len(read.points)),
        ("rows without a speed, left out", read.missing),
        ("longest time without a speed, s", round(read.longest_gap_s, 6) or None),
        ("speeds slightly below 0, set to 0", read.raised),
        ("rows of other vehicles, left out", read.others),
    ]
    shown = tuple((what, value if value is None else str(value)) for what, value in rows)
    return Sheet(
        name="trace-reading", title="How the file is read", columns=("what", "value"), rows=shown
    )


def _motion(time_s: Floats, speed: Floats, a: Floats, limit_mps2: float) -> Sheet:
    step_s = np.diff(time_s)
    mean = 0.5 * (speed[1:] + speed[:-1])
    distance_m = float((mean * step_s).sum())
    duration_s = float(time_s[-1] - time_s[0])
    stands = float(step_s[np.maximum(speed[1:], speed[:-1]) < _STANDS_MPS].sum())
    hard = np.abs(a) > limit_mps2
    rows: list[Row] = [
        ("first time", "s", float(time_s[0])),
        ("last time", "s", float(time_s[-1])),
        ("duration", "s", duration_s),
        ("step, median", "s", float(np.median(step_s))),
        ("step, longest", "s", float(step_s.max())),
        ("distance", "km", distance_m / 1e3),
        ("speed, first", "m/s", float(speed[0])),
        ("speed, smallest", "m/s", float(speed.min())),
        ("speed, mean", "m/s", distance_m / duration_s),
        ("speed, largest", "m/s", float(speed.max())),
        ("speed, largest", "km/h", float(speed.max()) * 3.6),
        ("standstill", "s", stands),
        ("acceleration, largest", "m/s²", float(max(a.max(), 0.0))),
        ("deceleration, largest", "m/s²", float(max(-a.min(), 0.0))),
        ("limit of commands", "m/s²", limit_mps2),
        ("beyond the limit", "s", float(step_s[hard].sum())),
    ]
    return Sheet(
        name="trace-motion",
        title="Motion that the trace asks for",
        columns=("figure", "unit", "value"),
        rows=tuple(rows),
    )


def _notes(read: Recording, a: Floats, limit_mps2: float) -> list[str]:
    first_s, first_mps = read.points[0]
    notes = []
    if first_s > _LATE_S and not read.from_first:
        notes.append(
            f"The trace begins {first_s:g} s after the event's at_s, as the times in the file say. "
            "With time: from-first it begins at once."
        )
    hard = int((np.abs(a) > limit_mps2).sum())
    if hard:
        notes.append(
            f"{hard} of {len(a)} steps are beyond ±{limit_mps2:g} m/s². The vehicle follows them, "
            "but the vehicles behind it cannot, unless control.acceleration_limit_mps2 is larger."
        )
    notes.append(f"To start without a jump in speed, set fleet.speed_mps: {first_mps:.6g}.")
    return notes


def _drawn(time_s: Floats, speed: Floats, a: Floats, limit_mps2: float) -> Figure:
    figure, axes = style.subplots(2, 1, height_in=4.6, sharex=True)
    axes[0].plot(time_s, speed, color=style.CYCLE[0])
    axes[0].set_ylabel("speed, m/s")
    axes[0].set_ylim(bottom=min(0.0, float(speed.min())))
    kmh = axes[0].secondary_yaxis("right", functions=(_to_kmh, _to_mps))
    kmh.set_ylabel("speed, km/h")
    axes[1].stairs(a, time_s, color=style.CYCLE[1], baseline=None, zorder=2)
    for limit in (-limit_mps2, limit_mps2):
        axes[1].axhline(limit, color=style.THEORY, ls="--", lw=0.9)
    axes[1].set_ylabel("acceleration, m/s²")
    axes[1].set_xlabel("time, s")
    axes[1].set_xlim(time_s[0], time_s[-1])
    return figure


def _to_kmh(speed: Any) -> Any:
    return speed * 3.6


def _to_mps(speed: Any) -> Any:
    return speed / 3.6
