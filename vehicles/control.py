"""The controllers of a vehicle: the laws that it runs over time, with their parameters."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

from zenvoy.laws import NoParameters, builtin, law_of
from zenvoy.scenarios import Scenario, Settings, modes, parameters_of, roster
from zenvoy.vehicles.decision import Controller

FOLLOWING: Final = Controller(law_of("FM"), NoParameters(), law_of("FM").mode or 0)


@lru_cache(maxsize=4)
def reports_commands(scenario: Scenario) -> bool:
    """Return whether beacons hold commands, because a law of the fleet needs them."""
    return any(
        law_of(model).hears_commands(parameters_of(scenario.control, law_of(model), given))
        for model, given in _phases(scenario)
    )


@lru_cache(maxsize=4)
def shares_links(scenario: Scenario) -> bool:
    """Return whether beacons hold odometers and offsets, which laws that share links need."""
    return any(law_of(model).needs.shares_links for model, _ in _phases(scenario))


def _phases(scenario: Scenario) -> set[tuple[str, tuple[tuple[str, Any], ...]]]:
    """Return every model that a vehicle runs at some time, with the parameters given for it."""
    phases = {phase for settings in roster(scenario) for phase in settings.phases}
    return {(phase.model, phase.parameters) for phase in phases}


def controllers(scenario: Scenario, settings: Settings) -> list[tuple[int, Controller]]:
    """Return each controller of a vehicle with the time (ns) from which it is in force."""
    numbers = modes(scenario)
    found = []
    for from_ns, model, given in settings.phases:
        law = law_of(model)
        parameters = parameters_of(scenario.control, law, given)
        limit_s = None if model in builtin() else scenario.stall_limit_s
        found.append((from_ns, Controller(law, parameters, numbers[model], limit_s)))
    return found
