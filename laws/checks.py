"""Checks the record of a user's own law or estimator, whose fields Python takes as they come."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any, Final, get_origin, get_type_hints

from pydantic import ValidationError

from zenvoy.laws.errors import described, shortened
from zenvoy.laws.estimator import Estimator
from zenvoy.laws.law import Column, Law, Needs
from zenvoy.laws.parameters import model_of

_COLOUR: Final = re.compile("#[0-9A-Fa-f]{6}")
_MOST_SIDES: Final = 100


def flaw_in(record: Law | Estimator) -> str | None:
    """Return the first field of a record that cannot be used, in a line; None if there is none."""
    found = _flaws_of_law(record) if isinstance(record, Law) else _flaws_of_estimator(record)
    for name, value, allowed in found:
        return f"{name} is {shortened(value)}; allowed: {allowed}"
    return None


def _flaws_of_estimator(record: Any) -> Iterator[tuple[str, Any, str]]:
    """Yield name, value and what is allowed, for each field that cannot be used."""
    if not _is_text(record.name):
        yield "name", record.name, "text in one line"
    if not callable(record.start):
        yield "start", record.start, "a function or a class"
    yield from _flaws_of_parameters(record.parameters)


def _flaws_of_law(law: Any) -> Iterator[tuple[str, Any, str]]:
    """Yield name, value and what is allowed, for each field that cannot be used."""
    if not _is_text(law.name):
        yield "name", law.name, "text in one line"
    if not callable(law.acceleration):
        yield "acceleration", law.acceleration, "a function"
    yield from _flaws_of_parameters(law.parameters)
    yield from _flaws_of_needs(law)
    yield from _flaws_of_columns(law.columns)
    if not (isinstance(law.state, tuple) and all(map(_is_number, law.state))):
        yield "state", law.state, "a tuple of numbers"
    if law.colour is not None and not (
        isinstance(law.colour, str) and _COLOUR.fullmatch(law.colour)
    ):
        yield "colour", law.colour, "None or #RRGGBB"
    if law.linear is not None and not callable(law.linear):
        yield "linear", law.linear, "None or a function"
    if not isinstance(law.version, str):
        yield "version", law.version, "text"


def _flaws_of_parameters(parameters: Any) -> Iterator[tuple[str, Any, str]]:
    if not (isinstance(parameters, type) and is_dataclass(parameters)):
        yield "parameters", parameters, "a dataclass (the class itself)"
        return
    try:
        why = _flaw_of_types(parameters)
    except Exception as error:  # noqa: BLE001 - types that pydantic cannot check raise many kinds
        why = described(error)
    if why:
        yield "parameters", parameters, f"a dataclass of numbers, text and tuples ({why})"


def _flaw_of_types(parameters: type) -> str | None:
    """Return why parameters cannot be checked, written to a log or compared; None if they can."""
    model = model_of(parameters)
    model.model_json_schema()
    defaults = {
        name: field.default for name, field in model.model_fields.items() if not field.is_required()
    }
    for hint in get_type_hints(parameters).values():
        if get_origin(hint) in {list, dict, set}:
            return f"{get_origin(hint).__name__} can change"
    hash(tuple(defaults.values()))
    try:
        model.model_validate(defaults).model_dump(mode="json")
    except ValidationError as refused:
        for error in refused.errors(include_url=False):
            if error["type"] != "missing":
                name = ".".join(map(str, error["loc"]))
                return f"{name} = {shortened(error['input'])}: {error['msg']}"
    return None


def _flaws_of_needs(law: Any) -> Iterator[tuple[str, Any, str]]:
    needs = law.needs
    if not isinstance(needs, Needs):
        yield "needs", needs, "Needs(…)"
        return
    names = [one.name for one in fields(law.parameters)]
    of_sides = type(needs.sides) is int and 0 <= needs.sides <= _MOST_SIDES
    if not (of_sides or needs.sides in names):
        yield "needs.sides", needs.sides, f"0 to {_MOST_SIDES}, or the name of a parameter"
    if not (isinstance(needs.commands, bool) or needs.commands in names):
        yield "needs.commands", needs.commands, "True, False, or the name of a parameter"


def _flaws_of_columns(columns: Any) -> Iterator[tuple[str, Any, str]]:
    allowed = "a tuple of Column(name, unit) with different names, each text in one line"
    is_good = isinstance(columns, tuple) and not isinstance(columns, Column)
    is_good = is_good and all(isinstance(one, Column) and _is_column(one) for one in columns)
    if not is_good or len({one.name for one in columns}) != len(columns):
        yield "columns", columns, allowed


def _is_column(column: Any) -> bool:
    return _is_text(column.name) and (column.unit == "" or _is_text(column.unit))


def _is_text(value: object) -> bool:
    return isinstance(value, str) and value.isprintable() and value.strip() == value != ""


def _is_number(value: object) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)
