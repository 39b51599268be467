"""Checks across sections: values that are fine alone and impossible together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from zenvoy.scenarios.agreement_of_events import events_that_disagree
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema import Scenario

_NS_PER_S = 1_000_000_000


class DisagreementError(ValueError):
    """Raised inside the validation of a Scenario; pydantic wraps it in its ValidationError."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))


def disagreements(scenario: Scenario) -> list[Problem]:
    """Every disagreement between values of `scenario`, without places."""
    return [
        *_lengths(scenario),
        *_ring(scenario),
        *_times(scenario),
        *_schedule(scenario),
        *events_that_disagree(scenario),
    ]


def refuse_disagreements(scenario: Scenario) -> None:
    """Raise DisagreementError if any two values of `scenario` disagree."""
    if problems := disagreements(scenario):
        raise DisagreementError(problems)


def _lengths(scenario: Scenario) -> Iterator[Problem]:
    """Gaps are measured from front to front: one of a vehicle's length is a collision."""
    length_m = scenario.fleet.length_m
    gaps = {
        "fleet.gap_m": scenario.fleet.gap_m,
        "control.desired_gap_m": scenario.control.desired_gap_m,
    }
    for key, gap_m in gaps.items():
        if gap_m <= length_m:
            text = f"{trimmed(gap_m)} is not greater than fleet.length_m ({trimmed(length_m)})"
            yield Problem(key=key, text=text, related=("fleet.length_m",))


def _ring(scenario: Scenario) -> Iterator[Problem]:
    """On a ring of two, the vehicle ahead and the vehicle behind are the same one."""
    control = scenario.control
    models: dict[str, str] = {"control.model": control.model}
    models |= {f"control.schedule.{i}.model": s.model for i, s in enumerate(control.schedule)}
    bilateral = next((key for key, model in models.items() if model != "FM"), None)
    if scenario.road.type == "ring" and bilateral and scenario.fleet.size < 3:
        need = f"which {models[bilateral]} needs on the ring"
        text = f"{scenario.fleet.size} is not at least 3, {need}"
        yield Problem(key="fleet.size", text=text, related=(bilateral, "road.type"))


def _times(scenario: Scenario) -> Iterator[Problem]:
    # Compared in ns, as the run does: what differs by less is equal there.
    period = f"period_ms ({trimmed(scenario.period_ms)})"
    if round(scenario.duration_s * _NS_PER_S) < scenario.period_ns:
        text = f"{trimmed(scenario.duration_s)} is not at least one period, {period}"
        yield Problem(key="duration_s", text=text, related=("period_ms",))
    if scenario.v2v_wait_ns >= scenario.period_ns:
        text = f"{trimmed(scenario.control.v2v_wait_ms)} is not less than {period}"
        yield Problem(key="control.v2v_wait_ms", text=text, related=("period_ms",))


def _schedule(scenario: Scenario) -> Iterator[Problem]:
    for index, (before, switch) in enumerate(pairwise(scenario.control.schedule), start=1):
        if round(switch.at_s * _NS_PER_S) <= round(before.at_s * _NS_PER_S):
            earlier = trimmed(before.at_s)
            text = f"{trimmed(switch.at_s)} is not later than the switch before ({earlier})"
            key = f"control.schedule.{index}.at_s"
            related = (f"control.schedule.{index - 1}.at_s",)
            yield Problem(key=key, text=text, related=related)
