"""The laws that a scenario names, their parameters, and their numbers in the log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from zenvoy.laws import Law, builtin, parameters_from
from zenvoy.laws.parameters import parameters_of as parameters_checked

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.control import Control
    from zenvoy.scenarios.schema.scenario import Scenario

_FIRST_MODE: Final = 64  # for laws that are not in the library; modes are below 128


def parameters_of(control: Control, law: Law, given: tuple[tuple[str, Any], ...] = ()) -> Any:
    """Return the parameters of a law, in the law's own type."""
    if law.section is not None:
        return parameters_from(law, getattr(control, law.section))
    return parameters_checked(law.parameters, dict(given))


def models_named(scenario: Scenario) -> list[str]:
    """Return every model that a scenario names, once, in order of its first mention."""
    control = scenario.control
    named = [control.model, *(switch.model for switch in control.schedule)]
    named += [group.model for group in scenario.fleet.groups]
    return list(dict.fromkeys(model for model in named if model is not None))


def key_of(scenario: Scenario, model: str) -> str:
    """Return the first key that names a model."""
    control = scenario.control
    keys = [
        ("control.model", control.model),
        *((f"control.schedule.{n}.model", one.model) for n, one in enumerate(control.schedule)),
        *((f"fleet.groups.{n}.model", one.model) for n, one in enumerate(scenario.fleet.groups)),
    ]
    return next(key for key, named in keys if named == model)


def modes(scenario: Scenario) -> dict[str, int]:
    """Return the mode, the number in the log, of every model that a scenario names.

    Laws of the library have fixed numbers; others are numbered from 64 on, in order of reference.
    """
    known = {model: law.mode for model, law in builtin().items() if law.mode is not None}
    others = sorted(model for model in models_named(scenario) if model not in known)
    numbered = {model: number for number, model in enumerate(others, start=_FIRST_MODE)}
    return {model: (known | numbered)[model] for model in models_named(scenario)}


def name_of(model: str) -> str:
    """Return the name of a model for messages: without the hash of its source."""
    return model.partition("#")[0]
