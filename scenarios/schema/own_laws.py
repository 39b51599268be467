"""Facts for the log about a scenario's own laws, so that a reader does not need their code."""

from __future__ import annotations

import json
from functools import partial
from typing import TYPE_CHECKING, Any

from zenvoy.laws import Law, Setpoint, builtin, law_of
from zenvoy.laws.errors import errors_of_the_code, raised
from zenvoy.scenarios.schema.control_laws import modes, parameters_of
from zenvoy.scenarios.schema.courses import Targets
from zenvoy.scenarios.schema.roster import Phase, roster

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

_NS_PER_S = 1_000_000_000


def own_laws(scenario: Scenario) -> dict[str, str]:
    """Return facts in JSON about every law that is not in the library, by its mode in the log.

    `linear` is the law linearised at its equilibrium for each set of parameters and each
    setpoint of the scenario; during a ramp between setpoints it is not known. Raises LawError if
    the law fails.
    """
    return {
        str(mode): json.dumps(_facts(scenario, model, law_of(model)), sort_keys=True)
        for model, mode in sorted(modes(scenario).items(), key=lambda one: one[1])
        if model not in builtin()
    }


def _facts(scenario: Scenario, model: str, law: Law) -> dict[str, Any]:
    reference, _, digest = model.partition("#")
    return {
        "name": law.name,
        "reference": reference,
        "source_hash": digest,
        "version": law.version,
        "columns": [list(column) for column in law.columns],
        "colour": law.colour,
        "looks_behind": law.two_sided(),
        "counts_sides": bool(law.needs.sides),
        "predicts": law.needs.prediction,
        "linear": _linear(scenario, model, law),
    }


def _linear(scenario: Scenario, model: str, law: Law) -> list[list[Any]]:
    """Return [parameters, setpoint, m, linear] for every use of the law in the scenario."""
    if law.linear is None:
        return []
    instants = {0}
    for switch in scenario.control.schedule:
        at_ns = round(switch.at_s * _NS_PER_S)
        instants |= {at_ns, at_ns + round(switch.ramp_s * _NS_PER_S)}
    wanted: dict[tuple[Any, Setpoint], Phase] = {}
    for settings in roster(scenario):
        for phase in settings.phases:
            if phase.model == model:
                for instant in instants:
                    setpoint = setpoint_at(settings.targets, instant)
                    wanted[phase.parameters, setpoint] = phase
    rows = []
    for (given, setpoint), phase in wanted.items():
        parameters = parameters_of(scenario.control, law, phase.parameters)
        for m in range(1, law.sides(parameters) + 1) if law.needs.sides else (0,):
            with errors_of_the_code(partial(raised, f"linear form of law {law.name}", law.linear)):
                linear = law.linear(parameters, setpoint, m)
                json.dumps(list(linear))  # fails here if it cannot be written
            rows.append([dict(given), list(setpoint), m, list(linear)])
    return rows


def setpoint_at(targets: Targets, time_ns: int) -> Setpoint:
    """Return the setpoint of a vehicle at a time."""
    return Setpoint(
        k_d=targets.k_d.at(time_ns),
        k_v=targets.k_v.at(time_ns),
        k_c=targets.k_c.at(time_ns),
        p_des=targets.desired_gap_m.at(time_ns),
        v_des=targets.desired_speed_mps.at(time_ns),
    )
