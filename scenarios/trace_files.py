"""The points of a trace out of a file, as the scenario says that it is to be read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from zenvoy.scenarios.columns import Choice, RecordingError
from zenvoy.scenarios.errors import InvalidScenarioError, Place, Problem
from zenvoy.scenarios.recordings import recording
from zenvoy.scenarios.tree import Node
from zenvoy.scenarios.units import SPEEDS, TIMES, unit_named
from zenvoy.scenarios.wording import shown, trimmed

TIME_WORDS: Final = ("as-given", "from-first")
OPTIONS: Final = ("column", "time_column", "unit", "time_unit", "time", "where")


def trace_file_schema() -> dict[str, dict[str, Any]]:
    """What a scenario may say of a trace's file, as JSON schema: for messages and the docs."""
    return {
        "file": {"type": "string"},
        "column": {"type": "string"},
        "time_column": {"type": "string"},
        "unit": {"enum": list(SPEEDS)},
        "time_unit": {"enum": list(TIMES)},
        "time": {"enum": list(TIME_WORDS)},
        "where": {"type": "object"},
    }


@dataclass(frozen=True, slots=True)
class TraceFile:
    """Reads a drive cycle or a recorded drive."""

    @property
    def options(self) -> tuple[str, ...]:
        """How to read it."""
        return OPTIONS

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """Points of [time_s, speed_mps], as `Reader` has it."""
        choice = _choice(key, options)
        try:
            read = recording(text, choice)
        except RecordingError as error:
            raise InvalidScenarioError(
                _problem(found, top, key, options) for found in error.problems
            ) from None
        points = zip(read.points, read.lines, strict=True)
        return Node(tuple(_point(point, replace(top, line=n)) for point, n in points), top)


def choice_of(values: Mapping[str, object]) -> Choice:
    """The choice that these options, by name, make. Raises ValueError: "unit: 3 is not …"."""
    said: dict[str, Any] = {}
    for name, value in values.items():
        try:
            said[name] = _READERS[name](value)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    return Choice(**said)


def _choice(key: str, options: Mapping[str, Node]) -> Choice:
    """As `choice_of`; raises InvalidScenarioError with all that is wrong."""
    said: dict[str, Any] = {}
    problems = []
    for name, node in options.items():
        try:
            said[name] = _READERS[name](node.plain())
        except ValueError as error:
            problems.append(Problem(key=f"{key}.{name}", text=str(error), place=node.place))
    if problems:
        raise InvalidScenarioError(problems)
    return Choice(**said)


def _problem(
    found: tuple[int | None, str, str], top: Place, key: str, options: Mapping[str, Node]
) -> Problem:
    """At the option that is wrong, where it is given; else at the line of the file."""
    line, name, text = found
    place = options[name].place if name in options else replace(top, line=line)
    return Problem(key=f"{key}.{name or 'file'}", text=text, place=place)


def _point(point: tuple[float, float], place: Place) -> Node:
    return Node((Node(point[0], place), Node(point[1], place)), place)


def _name(value: object) -> str:
    """A column's name; one that is a number in YAML is a text all the same."""
    if isinstance(value, str | int) and not isinstance(value, bool):
        return str(value)
    raise ValueError(f"{shown(value)} is not text, the name of a column")


def _unit(value: object) -> str:
    return _one_of(value, SPEEDS)


def _time_unit(value: object) -> str:
    return _one_of(value, TIMES)


def _one_of(value: object, units: Mapping[str, object]) -> str:
    unit = unit_named(value, units) if isinstance(value, str) else None
    if unit is None:
        raise ValueError(f"{shown(value)} is not one of {', '.join(units)}")
    return unit


def _time(value: object) -> str:
    if value not in TIME_WORDS:
        raise ValueError(f"{shown(value)} is not one of {', '.join(TIME_WORDS)}")
    return str(value)


def _where(value: object) -> dict[str, str]:
    if not isinstance(value, dict) or not all(map(_is_cell, value.values())):
        raise ValueError(f"{shown(value)} is not a mapping from columns to values")
    return {str(name): _cell(cell) for name, cell in value.items()}


def _is_cell(value: object) -> bool:
    return isinstance(value, str | int | float) and not isinstance(value, bool)


def _cell(value: str | int | float) -> str:
    return value.strip() if isinstance(value, str) else trimmed(value)


_READERS: Final = {
    "column": _name,
    "time_column": _name,
    "unit": _unit,
    "time_unit": _time_unit,
    "time": _time,
    "where": _where,
}
