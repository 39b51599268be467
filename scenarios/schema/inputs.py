"""Types of values that may be written in several forms, and are kept in one."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
)

from zenvoy.laws import builtin
from zenvoy.laws.by_name import ESTIMATORS, LAWS, Kind


def _set_text(value: object) -> object:
    """Return 5 as "5" and [1, "4-6"] as "1, 4-6"; leave other values for the schema to refuse."""
    items = value if isinstance(value, list | tuple) and value else [value]
    if all(isinstance(item, str | int) and not isinstance(item, bool) for item in items):
        return ", ".join(str(item).strip() for item in items)
    return value


def _weights(value: object) -> str | tuple[float, ...]:
    if value in ("least-squares", "uniform"):
        return str(value)
    if not isinstance(value, list | tuple) or not all(map(_is_weight, value)) or not any(value):
        raise ValueError
    return tuple(float(weight) for weight in value)


def _is_weight(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1e9


_REFERENCE: Final = re.compile(r"[^:#]+:[\w.]+(#[0-9a-f]+)?")


def _model(value: str) -> str:
    """Accept a built-in law, or a reference for `zenvoy.scenarios.reading.laws` to load."""
    if value not in builtin() and not _REFERENCE.fullmatch(value):
        raise ValueError
    return value


def _estimator(value: str) -> str:
    if value not in ESTIMATORS.taken() and not _REFERENCE.fullmatch(value):
        raise ValueError
    return value


def _parameters(value: object) -> tuple[tuple[str, Any], ...]:
    pairs = tuple(value.items()) if isinstance(value, dict) else value
    if not isinstance(pairs, tuple) or not all(isinstance(pair, tuple) for pair in pairs):
        raise ValueError
    return tuple((str(name), _frozen(item)) for name, item in pairs)


def _frozen(value: object) -> object:
    return tuple(map(_frozen, value)) if isinstance(value, list | tuple) else value


def _mapping(pairs: tuple[tuple[str, Any], ...]) -> dict[str, Any]:
    return {name: list(item) if isinstance(item, tuple) else item for name, item in pairs}


def _plain(weights: str | tuple[float, ...]) -> str | list[float]:
    return weights if isinstance(weights, str) else list(weights)


def written_as(words: str, *forms: dict[str, Any]) -> WithJsonSchema:
    """Describe a value that has several forms: in words for messages, and in JSON schema each."""
    return WithJsonSchema({"type": "string", "noun": words, "forms": list(forms)})


_OWN: Final = {"type": "string", "pattern": "^[^:#]+:[A-Za-z0-9_.]+$"}
_NUMBERS: Final = {"type": "array", "items": {"type": "number", "minimum": 0}, "minItems": 1}
_SET: Final = {"type": ["string", "integer"]}


def _named(kind: Kind) -> dict[str, Any]:
    """Return the JSON schema of a name out of a table, or of one's own code.

    `own` has the form of the latter in words, for messages.
    """
    choice = {"type": "string", "enum": list(kind.taken())}
    return {**choice, "own": kind.form, "forms": [choice, _OWN]}


GroupName = Annotated[
    str,
    Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$"),
    written_as(
        "a word of letters, digits and _ that begins with a letter",
        {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]*$"},
    ),
]
VehicleSet = Annotated[
    str,
    BeforeValidator(_set_text),
    written_as(
        'vehicles such as 5, 2-9, [1, 4-6], all, the name of a group, or "not" before these',
        _SET,
        {"type": "array", "items": _SET, "minItems": 1},
    ),
]
Model = Annotated[
    str,
    AfterValidator(_model),
    WithJsonSchema(_named(LAWS)),
]
"""A law of the library by name, or one of the scenario's own: file:NAME#hash."""
EstimatorKind = Annotated[
    str,
    AfterValidator(_estimator),
    WithJsonSchema(_named(ESTIMATORS)),
]
"""A built-in estimator by name, or one of the scenario's own: file:NAME#hash."""
Parameters = Annotated[
    tuple[tuple[str, Any], ...],
    PlainValidator(_parameters),
    PlainSerializer(_mapping),
    WithJsonSchema({"type": "object", "additionalProperties": True}),
]
"""Parameters of a law, kept as pairs so that a scenario is hashable."""
Weights = Annotated[
    str | tuple[float, ...],
    PlainValidator(_weights),
    PlainSerializer(_plain),
    written_as(
        "least-squares, uniform, or a list of numbers that are at least 0 and not all 0",
        {"enum": ["least-squares", "uniform"]},
        _NUMBERS,
    ),
]
