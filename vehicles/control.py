"""The controllers of a vehicle: which law it runs from when on, with which parameters."""

from __future__ import annotations

from typing import Final

from zenvoy.laws import NoParameters, law_of
from zenvoy.scenarios import Scenario, Settings, parameters_of
from zenvoy.vehicles.decision import Controller

FOLLOWING: Final = Controller(law_of("FM"), NoParameters(), law_of("FM").mode or 0)


def controllers(scenario: Scenario, settings: Settings) -> list[tuple[int, Controller]]:
    """Return each controller of a vehicle with the time (ns) from which it is in force."""
    return [(from_ns, controller(scenario, model)) for from_ns, model in settings.phases]


def controller(scenario: Scenario, model: str) -> Controller:
    """Return the controller of a model, with the parameters that the scenario gives it."""
    law = law_of(model)
    return Controller(law, parameters_of(scenario.control, law), law.mode or 0)
