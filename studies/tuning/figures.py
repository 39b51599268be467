"""The figures that a search may minimise, maximise or limit: measures of runs, and of theory."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from zenvoy.analysis.measures.figures import MEASURES, Measure
from zenvoy.analysis.theory.of_run import NoTheoryError
from zenvoy.analysis.theory.of_scenario import head_to_tail_gain
from zenvoy.scenarios import Scenario

_IN_THEORY: Final = {"head_to_tail_gain": head_to_tail_gain}

FIGURES: Final[Mapping[str, Measure]] = MappingProxyType(
    {
        **MEASURES,
        "head_to_tail_gain": Measure("", "largest gain of speed from head to tail, in theory"),
    }
)
"""Every figure that a study for `zenvoy tune` may name."""


def is_theoretical(name: str) -> bool:
    """Return whether a figure follows from the scenario alone."""
    return name in _IN_THEORY


def in_theory(name: str, scenario: Scenario) -> float | str:
    """Return a theoretical figure of a scenario, or a sentence on why there is none."""
    try:
        return _IN_THEORY[name](scenario)
    except NoTheoryError as error:
        return f"{name}: {error}"
