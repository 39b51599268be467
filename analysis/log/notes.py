"""Writes the notes that a reader must see before trusting the figures of a run."""

from __future__ import annotations

from collections.abc import Sequence

from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.facts import Facts
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_metadata import NOTES

_ASKED = "asked to end"  # text of the event after a signal, or when a process was lost
_MAX_NOTES, _MAX_NOTE_LENGTH = 100, 1_000  # notes on the scenario that are shown, characters each


def notes_of(facts: Facts, truth: Table, events: Sequence[pb.Event]) -> tuple[str, ...]:
    """Return a sentence for each cut, failed check, lost process, early end, or empty log.

    Then follow the notes on the scenario that were printed before the run.
    """
    last_s = float(truth["time_ns"][-1]) * 1e-9 if truth else 0.0
    notes = [facts.cut] if facts.cut else []
    notes += facts.faults
    if facts.repair:
        notes.append(f"the log was repaired; its faults: {facts.repair.get('found', 'unknown')}")
    if any(check.name == "cycles" and check.holds is False for check in facts.checks):
        notes.append(f"read up to {facts.read_s:g} s only, as cycles must be complete and in order")
    for event in events:
        if event.kind == pb.EVENT_PROCESS_LOST:
            notes.append(f"process {event.text} was lost at {event.time_ns * 1e-9:g} s")
    early = _early_end(facts, events, last_s)
    if early:
        notes.append(early)
    if not truth or len(truth["time_ns"]) < 2:
        notes.append("no cycle was logged")
    of_scenario = facts.run.get(NOTES, "").splitlines()[:_MAX_NOTES]
    return (*notes, *(f"the scenario: {note[:_MAX_NOTE_LENGTH]}" for note in of_scenario))


def _early_end(facts: Facts, events: Sequence[pb.Event], last_s: float) -> str:
    """Return how and when a run ended early; "" for a run that was complete."""
    stops = [event for event in events if event.kind == pb.EVENT_STOPPED]
    of = f"of {facts.duration_s:g} s"
    if stops and stops[0].text != _ASKED:
        return f"the run was stopped at {stops[0].time_ns * 1e-9:g} s {of}: {stops[0].text}"
    end = facts.result.get("end", "complete")
    at_s = float(facts.result.get("simulated_s", last_s))
    if stops or end == "stopped":
        return f"the run was interrupted at {at_s:g} s {of}"
    if facts.repair and end in {"cut", "damaged"}:
        return f"it is not known how the run ended; the log ends at {at_s:g} s {of}"
    return "" if end == "complete" else f"the run failed at {at_s:g} s {of}: {end}"
