"""What a reader of a run must know before believing its figures."""

from __future__ import annotations

from collections.abc import Sequence

from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.facts import Facts
from zenvoy.bus import messages_pb2 as pb

_ASKED = "asked to end"  # by a signal, or because a process was lost
_MOST, _LONGEST = 100, 1_000  # of what a log says of its scenario


def notes_of(facts: Facts, truth: Table, events: Sequence[pb.Event]) -> tuple[str, ...]:
    """A sentence each for a cut, an early end, a lost process, and nothing logged at all.

    Then those on the scenario, as they were told before the run.
    """
    last_s = float(truth["time_ns"][-1]) * 1e-9 if truth else 0.0
    notes = [facts.cut] if facts.cut else []
    notes += facts.faults
    if facts.repair:
        notes.append(f"the log was repaired; found before: {facts.repair.get('found', 'unknown')}")
    if any(check.name == "cycles" and check.holds is False for check in facts.checks):
        notes.append(f"row k is to be cycle k: read up to {facts.read_s:g} s, the rest left out")
    for event in events:
        if event.kind == pb.EVENT_PROCESS_LOST:
            notes.append(f"lost {event.text} at {event.time_ns * 1e-9:g} s")
    early = _early_end(facts, events, last_s)
    if early:
        notes.append(early)
    if not truth or len(truth["time_ns"]) < 2:
        notes.append("no cycle was logged")
    of_scenario = facts.run.get("notes", "").splitlines()[:_MOST]
    return (*notes, *(f"the scenario: {note[:_LONGEST]}" for note in of_scenario))


def _early_end(facts: Facts, events: Sequence[pb.Event], last_s: float) -> str:
    """How and when a run ended that did not run to its end; "" for one that did."""
    stops = [event for event in events if event.kind == pb.EVENT_STOPPED]
    of = f"of {facts.duration_s:g} s"
    if stops and stops[0].text != _ASKED:
        return f"the run was stopped at {stops[0].time_ns * 1e-9:g} s {of}: {stops[0].text}"
    end = facts.result.get("end", "complete")
    at_s = float(facts.result.get("simulated_s", last_s))
    if stops or end == "stopped":
        return f"the run was interrupted at {at_s:g} s {of}"
    if facts.repair and end in {"cut", "damaged"}:
        return f"how the run ended is not known: the log ends at {at_s:g} s {of}"
    return "" if end == "complete" else f"the run failed at {at_s:g} s {of}: {end}"
