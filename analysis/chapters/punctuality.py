"""The chapter on real time: lateness on the wall clock."""

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
    ("sense", "arrival of a sense at its vehicle, after t_k"),
    ("decision", "decision, after t_k + v2v_wait"),
    ("command", "arrival of a command at the world, after it should take effect"),
    ("delivery", "arrival of a frame at its receiver, after the drawn instant"),
)


def punctuality_section(run: Run) -> Section:
    """Return lateness, missed deadlines and drift of a run in real time; raises LogError."""
    found = punctuality(run)
    if found is None:
        return Section(title=_TITLE, notes=("No cycle was logged, so no lateness is known.",))
    note = (
        "Latencies and ages of information in other chapters are those that the channel draws. "
        "This chapter shows how much later things happened on the wall clock."
    )
    return Section(
        title=_TITLE, sheets=(_lateness(run, found), _deadlines(run, found)), notes=(note,)
    )


def _lateness(run: Run, found: Punctuality) -> Sheet:
    rows: list[tuple[Cell, ...]] = []
    for name, title in _ROWS:
        values = getattr(found, name)
        rows.append((title, len(values), *(quantiles(values) or (None, None, None))))
    return Sheet(
        name="realtime-lateness",
        title=f"Lateness on the wall clock, at {run.scenario.speed:g} × real time",
        columns=("what", "number", "median, ms", "99th percentile, ms", "largest, ms"),
        rows=tuple(rows),
        note="A negative value is early. A command must arrive before it takes effect.",
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
            ("frames that were due for a decision", due),
            ("of these, frames that missed it", missed),
            ("cycles that began more than 1 ms late", found.overruns),
            ("drift over the run, ms", found.drift_ms),
        ),
    )
