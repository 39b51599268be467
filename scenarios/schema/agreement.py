"""Checks across sections: values that are valid alone but not together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from pydantic import ValidationError

from zenvoy.laws import find, law_of
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.agreement_of_channel import channel_that_disagrees
from zenvoy.scenarios.schema.agreement_of_events import events_that_disagree
from zenvoy.scenarios.schema.agreement_of_faults import faults_that_disagree
from zenvoy.scenarios.schema.agreement_of_sets import sets_that_disagree
from zenvoy.scenarios.schema.agreement_of_start import start_that_disagrees
from zenvoy.scenarios.schema.control_laws import (
    key_of,
    models_named,
    name_of,
    parameters_of,
)
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.inputs import Parameters
    from zenvoy.scenarios.schema.scenario import Scenario

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000


class DisagreementError(ValueError):
    """Values disagree. It is raised while a Scenario is validated; pydantic wraps it."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))


def disagreements(scenario: Scenario) -> list[Problem]:
    """Return every disagreement between values of `scenario`, without places."""
    return [
        *_lengths(scenario),
        *start_that_disagrees(scenario),
        *_ring(scenario),
        *_weights(scenario),
        *_shared_links(scenario),
        *_names_of_laws(scenario),
        *sets_that_disagree(scenario),
        *_times(scenario),
        *_beacons(scenario),
        *_clock(scenario),
        *_schedule(scenario),
        *channel_that_disagrees(scenario),
        *events_that_disagree(scenario),
        *faults_that_disagree(scenario),
    ]


def refuse_disagreements(scenario: Scenario) -> None:
    """Raise DisagreementError if any two values of `scenario` disagree."""
    if problems := disagreements(scenario):
        raise DisagreementError(problems)


def _names_of_laws(scenario: Scenario) -> Iterator[Problem]:
    """Check that no two laws have the same name, which stands for a law in the log."""
    first: dict[str, str] = {}
    for model in models_named(scenario):
        law = find(model)
        if law is not None and first.setdefault(law.name, model) != model:
            text = (
                f"{name_of(model)} has the name of {name_of(first[law.name])}, {law.name};"
                " allowed: a name of its own for each law"
            )
            yield Problem(key=key_of(scenario, model), text=text)


def _lengths(scenario: Scenario) -> Iterator[Problem]:
    """Check that gaps, which are from front to front, exceed the length of a vehicle."""
    length_m = scenario.fleet.length_m
    gaps: dict[str, float | None] = {
        "fleet.gap_m": scenario.fleet.gap_m,
        "control.desired_gap_m": scenario.control.desired_gap_m,
    }
    for index, group in enumerate(scenario.fleet.groups):
        gaps[f"fleet.groups.{index}.desired_gap_m"] = group.desired_gap_m
    for index, switch in enumerate(scenario.control.schedule):
        gaps[f"control.schedule.{index}.desired_gap_m"] = switch.desired_gap_m
    for key, gap_m in gaps.items():
        if gap_m is not None and gap_m <= length_m:
            text = f"{trimmed(gap_m)} is not greater than fleet.length_m ({trimmed(length_m)})"
            yield Problem(key=key, text=text, related=("fleet.length_m",))


def _ring(scenario: Scenario) -> Iterator[Problem]:
    """Check that no vehicle on the ring is both ahead of and behind another within its law."""
    if scenario.road.type != "ring":
        return
    wanted = [
        (_smallest_ring(scenario, model, given), key, model)
        for key, model, given in _models(scenario)
    ]
    need, key, model = max(wanted, key=lambda want: want[0])
    if scenario.fleet.size < need:
        size, name = scenario.fleet.size, name_of(model)
        text = f"{size} is not at least {need}, which {name} needs on the ring"
        law = law_of(model)
        sides = (f"control.{law.section}.{law.needs.sides}",) if law.section else ()
        yield Problem(key="fleet.size", text=text, related=(key, "road.type", *sides))


def _smallest_ring(scenario: Scenario, model: str, given: Parameters) -> int:
    """Return how many vehicles the law of a model needs on a ring; 0 if its code is not loaded."""
    law = find(model)
    if law is None:
        return 0
    try:
        return law.smallest_ring(parameters_of(scenario.control, law, given))
    except ValidationError:  # a parameter is missing, which is reported when the law is loaded
        return 0


def _models(scenario: Scenario) -> Iterator[tuple[str, str, Parameters]]:
    """Yield the key of every model that is named, the model, and its parameters."""
    yield "control.model", scenario.control.model, scenario.control.parameters
    for index, switch in enumerate(scenario.control.schedule):
        if switch.model is not None:
            yield f"control.schedule.{index}.model", switch.model, switch.parameters
    for index, group in enumerate(scenario.fleet.groups):
        if group.model is not None:
            yield f"fleet.groups.{index}.model", group.model, group.parameters


def _weights(scenario: Scenario) -> Iterator[Problem]:
    multi = scenario.control.multi_node
    if not isinstance(multi.weights, str) and len(multi.weights) != multi.neighbours:
        key = "control.multi_node.neighbours"
        text = f"{len(multi.weights)} numbers, not one for each of {key} ({multi.neighbours})"
        yield Problem(key="control.multi_node.weights", text=text, related=(key,))


def _shared_links(scenario: Scenario) -> Iterator[Problem]:
    """Check that links which their vehicles share are measured by radar."""
    if scenario.control.neighbour_state == "radar":
        return
    for key, model, _ in _models(scenario):
        law = find(model)
        if law is not None and law.needs.shares_links:
            name = name_of(model)
            text = f"position does not go with {name}, which shares radar readings; allowed: radar"
            yield Problem(key="control.neighbour_state", text=text, related=(key,))
            return


def _times(scenario: Scenario) -> Iterator[Problem]:
    # Compare in ns, as the run does, where times that differ by less are equal.
    period = f"period_ms ({trimmed(scenario.period_ms)})"
    if round(scenario.duration_s * _NS_PER_S) < scenario.period_ns:
        text = f"{trimmed(scenario.duration_s)} is not at least one period, {period}"
        yield Problem(key="duration_s", text=text, related=("period_ms",))
    if scenario.v2v_wait_ns >= scenario.period_ns:
        text = f"{trimmed(scenario.control.v2v_wait_ms or 0.0)} is not less than {period}"
        yield Problem(key="control.v2v_wait_ms", text=text, related=("period_ms",))


def _beacons(scenario: Scenario) -> Iterator[Problem]:
    beacons = scenario.beacons
    if beacons.every != 1 and beacons.rule != "every-nth":
        text = f"{beacons.every} is given, but beacons.rule is {beacons.rule}; allowed: 1"
        yield Problem(key="beacons.every", text=text, related=("beacons.rule",))
    if beacons.period_ms is None:
        if beacons.staggered:
            text = "true needs beacons.period_ms; allowed without: false"
            yield Problem(key="beacons.staggered", text=text, related=("beacons.period_ms",))
        return
    given = trimmed(beacons.period_ms)
    if beacons.rule != "every-cycle":
        text = f"{given} is given, but beacons.rule is {beacons.rule}; allowed: null"
        yield Problem(key="beacons.period_ms", text=text, related=("beacons.rule",))
    elif round(beacons.period_ms * _NS_PER_MS) % scenario.period_ns:
        text = f"{given} is not a multiple of period_ms ({trimmed(scenario.period_ms)})"
        yield Problem(key="beacons.period_ms", text=text, related=("period_ms",))


def _clock(scenario: Scenario) -> Iterator[Problem]:
    """Check that no speed is given for lock-step, which always runs as fast as possible."""
    if scenario.clock == "lock-step" and scenario.speed != 1.0:
        text = f"{trimmed(scenario.speed)} needs clock: realtime; allowed in lock-step: 1"
        yield Problem(key="speed", text=text, related=("clock",))


def _schedule(scenario: Scenario) -> Iterator[Problem]:
    schedule = scenario.control.schedule
    for index, switch in enumerate(schedule):
        key = f"control.schedule.{index}"
        if switch.model is None and not switch.targets:
            text = "changes nothing; allowed: model, desired_gap_m, desired_speed_mps or gains"
            allowed = ("model", "desired_gap_m", "desired_speed_mps", "gains")
            yield Problem(key=key, text=text, related=tuple(f"{key}.{name}" for name in allowed))
        elif switch.ramp_s > 0.0 and not switch.targets:
            text = f"{trimmed(switch.ramp_s)} is given, but a model changes at once; allowed: 0"
            yield Problem(key=f"{key}.ramp_s", text=text, related=(f"{key}.model",))
    for index, (before, switch) in enumerate(pairwise(schedule), start=1):
        at_ns, before_ns = round(switch.at_s * _NS_PER_S), round(before.at_s * _NS_PER_S)
        # Two entries may have the same time only if they concern different vehicles.
        if at_ns < before_ns or (at_ns == before_ns and switch.vehicles == before.vehicles):
            earlier = trimmed(before.at_s)
            text = f"{trimmed(switch.at_s)} is not later than the switch before ({earlier})"
            key = f"control.schedule.{index}.at_s"
            related = (f"control.schedule.{index - 1}.at_s",)
            yield Problem(key=key, text=text, related=related)
