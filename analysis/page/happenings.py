"""Lists what happened in a run and explains its figures: brakes, switches, outages, losses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, Literal, NamedTuple

from zenvoy.analysis.log.event_words import event_words
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.faults import FaultSpan, fault_spans
from zenvoy.analysis.measures.spacing import FRONTS, spacing_of
from zenvoy.analysis.measures.spans import Disturbance, disturbances
from zenvoy.analysis.page.section import Sheet
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Outage, Rule, Scenario
from zenvoy.values.wording import spans

Kind = Literal["brake", "trace", "switch", "manoeuvre", "outage", "rule", "fault", "incident"]

_INCIDENTS: Final = {
    pb.EVENT_COLLISION,
    pb.EVENT_PROCESS_LOST,
    pb.EVENT_PROCESS_BACK,
    pb.EVENT_SILENT,
    pb.EVENT_SILENT_END,
    pb.EVENT_STOPPED,
}

_UNITS: Final = {"_mps": " m/s", "_m": " m"}


class Happening(NamedTuple):
    """What happened from start_s to end_s, in words; both are equal for what takes no time.

    An end beyond the run is infinite.
    """

    kind: Kind
    start_s: float
    end_s: float
    text: str


def happenings(run: Run) -> list[Happening]:
    """Return everything except fallbacks, of which there may be hundreds, in order of time."""
    last_s = float(run.time_s[-1]) if len(run.time_s) else 0.0
    found = [_disturbance(disturbance) for disturbance in disturbances(run.events)]
    found += [Happening("switch", at_s, at_s, text) for at_s, text in switches(run.events)]
    found += manoeuvres(run.scenario, last_s)
    found += impairments(run.scenario, last_s)
    found += [_fault(fault) for fault in fault_spans(run.events)]
    found += _incidents(run.events)
    return sorted(found, key=lambda happening: happening.start_s)


def switches(events: Sequence[pb.Event]) -> list[tuple[float, str]]:
    """Return when the schedule switched models (s), and to which, without the initial models."""
    return [
        (event.time_ns * 1e-9, f"switch to {event.text}")
        for event in events
        if event.kind == pb.EVENT_MODEL and event.time_ns > 0
    ]


def manoeuvres(scenario: Scenario, last_s: float) -> list[Happening]:
    """Return the changes of desired gap, desired speed or gains that begin before `last_s`."""
    found = []
    for switch in scenario.control.schedule:
        if switch.targets and 0.0 < switch.at_s < last_s:
            changes = [_change(scenario, *target) for target in switch.targets.items()]
            whom = "" if switch.vehicles is None else f" of {_vehicles(switch.vehicles)}"
            text = f"new targets{whom}: {', '.join(changes)}"
            found.append(Happening("manoeuvre", switch.at_s, switch.at_s + switch.ramp_s, text))
    return found


def impairments(scenario: Scenario, last_s: float) -> list[Happening]:
    """Return the outages and rules of the channel that begin before `last_s`."""
    channel = scenario.channel
    scopes: list[tuple[Kind, Outage | Rule, str]] = [
        *(("outage", outage, "outage: no frame gets through") for outage in channel.outages),
        *(("rule", rule, f"changed {_changed(rule)}") for rule in channel.rules),
    ]
    return [
        Happening(kind, scope.from_s, _end(scope, last_s), f"{text}{_where(scope)}")
        for kind, scope, text in scopes
        if scope.from_s < last_s
    ]


def sentences(found: Sequence[Happening], last_s: float) -> list[str]:
    """Return a sentence for each, for the notes of a chapter."""
    return [f"{_when(happening, last_s)} {happening.text}." for happening in found]


def timeline(run: Run) -> Sheet | None:
    """Return a row for each thing that happened; None where nothing did."""
    found = happenings(run)
    if not found:
        return None
    last_s = float(run.time_s[-1])
    return Sheet(
        name="timeline",
        title="What happened",
        columns=("from, s", "to, s", "what"),
        rows=tuple(
            (
                happening.start_s,
                None if happening.end_s == happening.start_s else min(happening.end_s, last_s),
                happening.text,
            )
            for happening in found
        ),
        note="Pictures over time shade brakes, traces, outages, rules and faults, and show "
        "switches as dashed lines. They do not shade what lasts for the whole run.",
    )


def _disturbance(of: Disturbance) -> Happening:
    verb = "brakes with" if of.kind == "brake" else "follows a"
    return Happening(of.kind, of.start_s, of.end_s, f"vehicle {of.vehicle} {verb} {of.text}")


def _fault(of: FaultSpan) -> Happening:
    text = f"fault of {_vehicles(spans(of.vehicles))}: {of.text}"
    return Happening("fault", of.start_s, of.end_s, text)


def _change(scenario: Scenario, name: str, value: float) -> str:
    """Return a target with its unit: "desired gap 35 m"."""
    spacing = spacing_of(scenario) if name == "desired_gap_m" else FRONTS
    how = f" {spacing.words}" if spacing.words else ""
    value = spacing.shown(value)
    unit = next((unit for suffix, unit in _UNITS.items() if name.endswith(suffix)), "")
    stem = name.removesuffix("_m").removesuffix("_mps")
    return f"{stem if stem.startswith('k_') else stem.replace('_', ' ')} {value:g}{unit}{how}"


def _incidents(events: Sequence[pb.Event]) -> Iterator[Happening]:
    for event in events:
        if event.kind in _INCIDENTS:
            at_s = event.time_ns * 1e-9
            yield Happening("incident", at_s, at_s, event_words(event))


def _changed(rule: Rule) -> str:
    """Return what a rule of the channel changes: "loss and latency"."""
    settings = {"loss": rule.loss, "latency": rule.latency}
    return " and ".join(name for name, value in settings.items() if value is not None) or "nothing"


def _where(scope: Outage | Rule) -> str:
    words = ""
    if scope.source is not None:
        words += f" from {_vehicles(scope.source)}"
    if scope.destination is not None:
        words += f" to {_vehicles(scope.destination)}"
    if scope.from_m is not None or scope.to_m is not None:
        low = "the start" if scope.from_m is None else f"{scope.from_m:g} m"
        high = "the end" if scope.to_m is None else f"{scope.to_m:g} m"
        words += f" on the road from {low} to {high}"
    return words


def _vehicles(chosen: str) -> str:
    """Return a set of vehicles in words, from numbers or the name of a group."""
    if chosen.isdigit():
        return f"vehicle {chosen}"
    return f"vehicles {chosen}" if chosen[:1].isdigit() else chosen


def _end(scope: Outage | Rule, last_s: float) -> float:
    until_s = math.inf if scope.until_s is None else scope.until_s
    return until_s if until_s < last_s else math.inf


def _when(happening: Happening, last_s: float) -> str:
    if happening.end_s == happening.start_s:
        return f"At {happening.start_s:g} s:"
    if happening.start_s <= 0.0 and happening.end_s >= last_s:
        return "Through the whole run:"
    end = f"{happening.end_s:g} s" if math.isfinite(happening.end_s) else "the end"
    return f"From {happening.start_s:g} s to {end}:"
