"""Chooses the engine that runs a scenario."""

from __future__ import annotations

from typing import NamedTuple

from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.fleet.engine import Choice, Engine
from zenvoy.scenarios import Scenario


class EngineError(Exception):
    """The engine that was asked for cannot run the scenario; the text has a line per reason."""


class Chosen(NamedTuple):
    """An engine, and for "auto" a line on each setting that the array engine does not run."""

    engine: Engine
    not_arrays: tuple[str, ...] = ()


def choose(asked: Choice, scenario: Scenario) -> Chosen:
    """Return the engine that runs a scenario; raises EngineError."""
    match asked:
        case "processes" | "in-process":
            return Chosen(asked)
    lines = tuple(uncovered(scenario))
    if not lines:
        return Chosen("arrays")
    if asked == "arrays":
        raise EngineError("\n".join(lines))
    return Chosen("in-process", lines)
