"""Derives the input of linear theory from a scenario alone: the laws and gains of its start."""

from __future__ import annotations

from zenvoy.analysis.theory.chain import Member, open_road
from zenvoy.analysis.theory.head_to_tail import head_to_tail
from zenvoy.analysis.theory.laws import Coupling, total_delay_s
from zenvoy.analysis.theory.of_run import NoTheoryError, require_theory
from zenvoy.laws.table import law_of
from zenvoy.scenarios import Gains, Scenario, Settings, parameters_of, roster, setpoint_at


def head_to_tail_gain(scenario: Scenario) -> float:
    """Return the largest gain of speed from the first vehicle to the last, over all frequencies.

    Every beacon arrives in time, so no vehicle falls back. The string is stable if the gain is 1.
    Raises NoTheoryError, also for a ring, which has neither head nor tail.
    """
    if scenario.road.type == "ring":
        raise NoTheoryError("a ring has no head and no tail; it needs road.type: open.")
    return head_to_tail(string_of(scenario)).gain


def string_of(scenario: Scenario) -> list[Member]:
    """Return the vehicles of an open road in linear theory, under the laws of the start.

    Raises NoTheoryError.
    """
    require_theory(scenario)
    members = open_road(
        [_member(scenario, settings, i) for i, settings in enumerate(roster(scenario), start=1)]
    )
    if min(member.gains.k_d for member in members[1:]) <= 0.0:
        raise NoTheoryError("k_d is 0, so nothing restores the gaps.")
    return members


def _member(scenario: Scenario, settings: Settings, vehicle: int) -> Member:
    control, first = scenario.control, settings.phases[0]
    law, setpoint = law_of(first.model), setpoint_at(settings.targets, 0)
    delay_s = total_delay_s(control, scenario.period_ms, predicts=law.needs.prediction)
    if law.linear is None:
        raise NoTheoryError(f"vehicle {vehicle} runs {law.name}, which has no linear form.")
    parameters = parameters_of(control, law, first.parameters)
    linear = law.linear(parameters, setpoint, law.sides(parameters))
    gains = Gains(k_d=linear.k_d, k_v=linear.k_v, k_c=linear.k_c)
    return Member(Coupling(linear.ahead, linear.behind), gains, delay_s, settings.lag_s)
