"""Notes on a scenario: settings that are allowed but probably a mistake."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

from zenvoy.laws import Law, Needs, find
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.notes_of_channel import notes_of_channel
from zenvoy.scenarios.schema.notes_of_events import notes_of_events
from zenvoy.scenarios.schema.notes_of_faults import notes_of_faults
from zenvoy.scenarios.schema.roster import group_members, roster
from zenvoy.values.section import NS_PER_S
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

Sets = dict[str, frozenset[int]]


def notes_of(scenario: Scenario) -> list[Problem]:
    """Return the notes on a valid scenario, without places."""
    sets = group_members(scenario)
    return [
        *_start(scenario, sets),
        *_groups(scenario, sets),
        *_schedule(scenario),
        *notes_of_channel(scenario, sets),
        *notes_of_events(scenario),
        *notes_of_faults(scenario),
    ]


def _start(scenario: Scenario, sets: Sets) -> Iterator[Problem]:
    """Note if the fleet does not start at the desired gap, or vehicle 1 at the desired speed."""
    fleet, control = scenario.fleet, scenario.control
    own_gap, own_speed = (
        {v for group in fleet.groups if getattr(group, name) is not None for v in sets[group.name]}
        for name in ("desired_gap_m", "desired_speed_mps")
    )
    even = fleet.initial_gaps_m is None
    differs = control.desired_gap_m != fleet.gap_m and len(own_gap) < fleet.size
    if even and differs and not _only_time_gaps(scenario):
        text = f"{trimmed(control.desired_gap_m)} is not fleet.gap_m ({trimmed(fleet.gap_m)}), "
        text += "at which the fleet starts"
        text += ", and which the ring keeps on average" if scenario.ring_length_m else ""
        yield Problem(key="control.desired_gap_m", text=text, related=("fleet.gap_m",))
    profile = any(event.vehicle == 1 for event in scenario.profiles)
    scheduled = any(switch.desired_speed_mps is not None for switch in control.schedule)
    if scenario.road.type == "open" and not profile and not scheduled and 2 not in own_speed:
        desired_mps = control.desired_speed_mps
        first_mps = fleet.speeds_at_start_mps[0]
        if desired_mps != first_mps:
            key = "speed_mps" if fleet.initial_speeds_mps is None else "initial_speeds_mps.0"
            text = f"{trimmed(desired_mps)} is not fleet.{key} ({trimmed(first_mps)}), "
            text += "which the first vehicle keeps"
            related = (f"fleet.{key}", "road.type")
            yield Problem(key="control.desired_speed_mps", text=text, related=related)


def _groups(scenario: Scenario, sets: Sets) -> Iterator[Problem]:
    for index, group in enumerate(scenario.fleet.groups):
        if not sets[group.name]:
            part = "share" if group.vehicles is None else "vehicles"
            text = f"none of the {scenario.fleet.size} vehicles is in this group"
            yield Problem(key=f"fleet.groups.{index}.{part}", text=text, related=("fleet.size",))


def _schedule(scenario: Scenario) -> Iterator[Problem]:
    end_s = scenario.cycles * scenario.period_ns / NS_PER_S
    last_ns = _last_desired_gap_ns(scenario)
    for index, switch in enumerate(scenario.control.schedule):
        if switch.at_s >= end_s:
            text = f"{trimmed(switch.at_s)} is not before the end of the run ({trimmed(end_s)} s)"
            key = f"control.schedule.{index}.at_s"
            yield Problem(key=key, text=text, related=("duration_s",))
        elif switch.desired_gap_m is not None and round(switch.at_s * NS_PER_S) >= last_ns:
            text = f"{trimmed(switch.desired_gap_m)} has no effect: no law uses it from then on"
            key = f"control.schedule.{index}.desired_gap_m"
            yield Problem(key=key, text=text, related=(f"control.schedule.{index}",))


def _last_desired_gap_ns(scenario: Scenario) -> float:
    """Return the time until which some law uses the desired gap, ns.

    On the open road the last vehicle uses it under a law that looks behind.
    """
    last_ns, is_open = 0.0, scenario.ring_length_m is None
    for settings in roster(scenario):
        ends = [*(phase.from_ns for phase in settings.phases[1:]), inf]
        for phase, end_ns in zip(settings.phases, ends, strict=True):
            law = find(phase.model)
            if law is None or law.keeps_gap or (is_open and law.two_sided()):
                last_ns = max(last_ns, end_ns)
    return last_ns


def _only_time_gaps(scenario: Scenario) -> bool:
    """Return whether no vehicle ever keeps a desired gap, not even after a fallback."""
    laws = [find(model) for settings in roster(scenario) for model in settings.models]
    by_radar = scenario.control.neighbour_state == "radar"
    return by_radar and all(
        law is not None and not law.keeps_gap and _needs_no_report(law) for law in laws
    )


def _needs_no_report(law: Law) -> bool:
    """Return whether a law needs nothing that only another vehicle's beacon can tell."""
    return replace(law.needs, prediction=False) == Needs()
