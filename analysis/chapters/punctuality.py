"""The chapter on real time: how late things were on the wall clock."""

from __future__ import annotations

from typing import Final

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.punctuality import (
    Punctuality,
    missed_decisions,
    punctuality,
    quantiles,
)
from zenvoy.analysis.page.section import Cell, Section, Sheet

_TITLE: Final = "Real time"
_ROWS: Final = (
    ("cycle", "beginning of a cycle, after t_k"),
    ("sense", "sense at its vehicle, after t_k"),
    ("decision", "decision, after t_k + v2v_wait"),
    ("command", "command at the world, after it was to take effect"),
    ("delivery", "frame at its receiver, after the instant drawn"),
)


def punctuality_section(run: Run) -> Section:
    """Lateness, missed deadlines and drift of a run in real time; raises LogError."""
    found = punctuality(run)
    if found is None:
        return Section(title=_TITLE, notes=("No cycle tells of how it kept to the clock.",))
    note = (
        "Latencies and ages of information in other chapters are those that were drawn; what came "
        "later than that is told here."
    )
    return Section(
        title=_TITLE, sheets=(_lateness(run, found), _deadlines(run, found)), notes=(note,)
    )


def _lateness(run: Run, found: Punctuality) -> Sheet:
    rows: list[tuple[Cell, ...]] = []
    for name, told in _ROWS:
        values = getattr(found, name)
        rows.append((told, len(values), *(quantiles(values) or (None, None, None))))
    return Sheet(
        name="realtime-lateness",
        title=f"Lateness on the wall clock, at {run.scenario.speed:g} × real time",
        columns=("of", "number", "median, ms", "99th percentile, ms", "most, ms"),
        rows=tuple(rows),
        note="What is below 0 was early: a command is to be there before it takes effect.",
    )


def _deadlines(run: Run, found: Punctuality) -> Sheet:
    missed, due = missed_decisions(run)
    return Sheet(
        name="realtime-deadlines",
        title="Deadlines",
        columns=("what", "number"),
        rows=(
            ("commands that came too late", found.commands_late),
            ("commands that never came", found.commands_missing),
            ("frames that missed the decision they were due for", missed),
            ("of frames that were due for one", due),
            ("cycles that began more than 1 ms late", found.overruns),
            ("drift over the run, ms", found.drift_ms),
        ),
    )
