"""The chapter "Manoeuvres": gaps and speeds compared with those that the schedule asks for."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final, Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.instants import row_at
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.analysis.page.style import CYCLE, legend, subplots
from zenvoy.links.distance import gaps
from zenvoy.scenarios import Course, roster

Floats = NDArray[np.float64]
Row = tuple[Cell, ...]
Kind = Literal["gap", "speed"]

_REACHED: Final = 0.05  # of the change; a value that is nearer is reached
_MAX_LINES: Final = len(CYCLE)


class Change(NamedTuple):
    """A change that the schedule asks of a vehicle (1..n): a straight ramp between two values."""

    vehicle: int
    kind: Kind
    start_s: float
    end_s: float
    before: float
    after: float


def manoeuvres_section(run: Run) -> Section | None:
    """Compare desired and actual gaps and speeds; None where the schedule changes neither."""
    found = changes(run)
    if not found:
        return None
    shown = {kind: _vehicles(found, kind) for kind in ("gap", "speed")}
    notes = [
        f"{len(vehicles)} vehicles change their {kind}; the picture shows the first {_MAX_LINES}."
        for kind, vehicles in shown.items()
        if len(vehicles) > _MAX_LINES
    ]
    return Section(
        title="Manoeuvres",
        notes=tuple(notes),
        sheets=(_sheet(run, found),),
        pictures=(
            Picture(
                name="manoeuvres",
                caption=(
                    "Actual (solid) and desired (dashed) gaps and speeds of the vehicles for which "
                    f"the schedule changes them. Gaps are from {_words(run)}. Under a law with a "
                    "desired gap the solid line approaches the dashed one."
                ),
                draw=lambda: _drawn(run, found),
            ),
        ),
    )


def changes(run: Run) -> list[Change]:
    """Return every change within the run, in order of time; the first vehicle may have no gap."""
    last_s = float(run.time_s[-1])
    found = []
    for vehicle, settings in enumerate(roster(run.scenario), start=1):
        kinds: list[tuple[Kind, Course]] = [("speed", settings.targets.desired_speed_mps)]
        if vehicle > 1 or run.scenario.ring_length_m is not None:
            kinds.append(("gap", settings.targets.desired_gap_m))
        found += [
            Change(vehicle, kind, *_shown(run, kind, change))
            for kind, course in kinds
            for change in _of_course(course)
            if change[0] < last_s
        ]
    return sorted(found, key=lambda change: (change.start_s, change.vehicle))


def _of_course(course: Course) -> Iterator[tuple[float, float, float, float]]:
    for (start_ns, before), (end_ns, after) in pairwise(course.points):
        if before != after:
            yield start_ns / 1e9, end_ns / 1e9, before, after


def _shown(
    run: Run, kind: Kind, change: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Return a change with its gaps as the report gives them."""
    start_s, end_s, before, after = change
    if kind == "gap":
        spacing = spacing_of(run.scenario)
        before, after = spacing.shown(before), spacing.shown(after)
    return start_s, end_s, before, after


def _words(run: Run) -> str:
    return spacing_of(run.scenario).of_gaps


def _vehicles(found: list[Change], kind: str) -> list[int]:
    return sorted({change.vehicle for change in found if change.kind == kind})


def _sheet(run: Run, found: list[Change]) -> Sheet:
    settings = roster(run.scenario)
    actual = {"gap": _gaps(run), "speed": run.truth["speed"]}
    desired_gap = spacing_of(run.scenario).named("desired gap", "m")
    units = {"gap": desired_gap, "speed": "desired speed, m/s"}
    rows: list[Row] = []
    for change in found:
        values = actual[change.kind][:, change.vehicle - 1]
        until_s = min(
            (
                other.start_s
                for other in found
                if (other.vehicle, other.kind) == (change.vehicle, change.kind)
                and other.start_s > change.start_s
            ),
            default=float(run.time_s[-1]),
        )
        phases = settings[change.vehicle - 1].phases
        model = phases[bisect_right(phases, round(change.end_s * 1e9), key=lambda p: p[0]) - 1][1]
        rows.append(
            (
                change.start_s,
                change.end_s,
                change.vehicle,
                model,
                units[change.kind],
                change.before,
                change.after,
                _at(run.time_s, values, change.end_s),
                _at(run.time_s, values, until_s),
                _reached_s(run.time_s, values, change, until_s),
            )
        )
    return Sheet(
        name="manoeuvres",
        title="Desired and actual changes",
        columns=(
            "from, s",
            "to, s",
            "vehicle",
            "model",
            "what",
            "before",
            "after",
            "actual at the end of the change",
            "actual before the next",
            "reached at, s",
        ),
        rows=tuple(rows),
        note="A value is reached when it stays within 5 % of the change around the desired value, "
        "until the next change or the end of the run. BCM, MBCM and PBCM balance gaps and have no "
        "desired gap, except in the last vehicle of the open road.",
    )


def _gaps(run: Run) -> Floats:
    gap = gaps(run.truth["position"], run.scenario.ring_length_m)
    return spacing_of(run.scenario).shown(gap)


def _at(time_s: Floats, values: Floats, at_s: float) -> float | None:
    """Return the value in the cycle that begins at that time; None after the end of the run."""
    if at_s > time_s[-1] + 1e-9:
        return None
    return float(values[row_at(time_s, at_s)])


def _reached_s(time_s: Floats, values: Floats, change: Change, until_s: float) -> float | None:
    """Return the time from which the value stays reached; None if it never does."""
    rows = np.flatnonzero((time_s >= change.start_s - 1e-9) & (time_s <= until_s + 1e-9))
    band = _REACHED * abs(change.after - change.before)
    out = np.flatnonzero(np.abs(values[rows] - change.after) > band)
    first = int(out[-1]) + 1 if out.size else 0
    return float(time_s[rows[first]]) if first < rows.size else None


def _drawn(run: Run, found: list[Change]) -> Figure:
    kinds = [kind for kind in ("gap", "speed") if _vehicles(found, kind)]
    figure, axes = subplots(
        len(kinds), height_in=0.6 + 2.3 * len(kinds), sharex=True, squeeze=False
    )
    settings, marked = roster(run.scenario), happenings(run)
    spacing = spacing_of(run.scenario)
    for one, kind in zip(axes[:, 0], kinds, strict=True):
        values = _gaps(run) if kind == "gap" else run.truth["speed"]
        for colour, vehicle in zip(CYCLE, _vehicles(found, kind), strict=False):
            targets = settings[vehicle - 1].targets
            course = targets.desired_gap_m if kind == "gap" else targets.desired_speed_mps
            one.plot(run.time_s, values[:, vehicle - 1], color=colour, label=f"vehicle {vehicle}")
            less_m = spacing.less_m if kind == "gap" else 0.0
            _plot(one, course, less_m, float(run.time_s[-1]), colour)
        one.set_xlim(run.time_s[0], run.time_s[-1])
        mark(one, marked)
        one.set_ylabel(spacing.named("gap ahead", "m") if kind == "gap" else "speed, m/s")
        legend(one)
    axes[-1, 0].set_xlabel("time, s")
    return figure


def _plot(axes: Any, course: Course, less_m: float, last_s: float, colour: str) -> None:
    """Draw a course: straight lines between its points, and its last value to the run's end.

    Gaps are drawn less a length, m.
    """
    times = [time_ns * 1e-9 for time_ns, _ in course.points]
    values = [value - less_m for _, value in course.points]
    axes.plot(
        [*times, max(last_s, times[-1])], [*values, values[-1]], color=colour, ls="--", lw=0.9
    )
