"""The options of a trace for reading its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Final

from zenvoy.scenarios.schema.units import SPEEDS, TIMES, unit_named
from zenvoy.values.wording import shown, trimmed

TIME_WORDS: Final = ("as-given", "from-first")


def trace_file_schema() -> dict[str, dict[str, Any]]:
    """Return the options as JSON schema, for messages and the reference."""
    return {
        "file": {
            "type": "string",
            "description": "A table, relative to the scenario file; instead of points.",
        },
        "column": {
            "type": "string",
            "description": "Name of the file's column of speeds; default: the column that is "
            "called a speed.",
        },
        "time_column": {
            "type": "string",
            "description": "Name of the file's column of times; default: the column that is "
            "called a time.",
        },
        "unit": {
            "enum": list(SPEEDS),
            "description": "Unit of the speeds; default: from the header.",
        },
        "time_unit": {
            "enum": list(TIMES),
            "description": "Unit of the times; default: from the header, else s.",
        },
        "time": {
            "enum": list(TIME_WORDS),
            "description": "`from-first`: the first point is time 0; default for dates, else "
            "as-given.",
        },
        "where": {
            "type": "object",
            "description": "Columns and their values; only rows with these values are read.",
        },
    }


def _name(value: object) -> str:
    """Return the name of a column as text, even if YAML reads it as a number."""
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


# By name of the option: a function that converts a given value, or raises ValueError.
READERS: Final[Mapping[str, Callable[[object], Any]]] = MappingProxyType(
    {
        "column": _name,
        "time_column": _name,
        "unit": _unit,
        "time_unit": _time_unit,
        "time": _time,
        "where": _where,
    }
)
