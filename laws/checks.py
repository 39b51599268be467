"""Checks the record of a user's own law or estimator, whose fields Python takes as they come."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any, Final, NamedTuple, get_origin, get_type_hints

from pydantic import ValidationError

from zenvoy.laws.errors import described, errors_of_the_code, shortened
from zenvoy.laws.estimator import Estimator
from zenvoy.laws.law import Column, Law, Needs
from zenvoy.laws.parameters import model_of

_COLOUR: Final = re.compile("#[0-9A-Fa-f]{6}")
_MOST_SIDES: Final = 100


class _Refused(NamedTuple):
    """A field that cannot be used: its name, its value, and what is allowed."""

    name: str
    value: Any
    allowed: str


class _ParametersError(Exception):
    """The class of parameters, which is a user's code, raised an exception."""


def _is_text(value: object) -> bool:
    return isinstance(value, str) and value.isprintable() and value.strip() == value != ""


def _is_state(value: object) -> bool:
    return isinstance(value, tuple) and all(type(one) in {float, int} for one in value)


def _is_colour(value: object) -> bool:
    return value is None or (isinstance(value, str) and _COLOUR.fullmatch(value) is not None)


def _is_linear(value: object) -> bool:
    return value is None or callable(value)


def _are_columns(value: object) -> bool:
    if not isinstance(value, tuple) or not all(isinstance(one, Column) for one in value):
        return False
    names = {one.name for one in value}
    texts = [*names, *(one.unit for one in value if one.unit != "")]
    return all(map(_is_text, texts)) and len(names) == len(value)


# What each field must be, apart from `parameters` and `needs`: a check, and the same in words.
_Rules = dict[str, tuple[Callable[[object], bool], str]]
_LAW: Final[_Rules] = {
    "name": (_is_text, "text in one line"),
    "acceleration": (callable, "a function"),
    "columns": (
        _are_columns,
        "a tuple of Column(name, unit) with different names, each text in one line",
    ),
    "state": (_is_state, "a tuple of numbers"),
    "colour": (_is_colour, "None or #RRGGBB"),
    "linear": (_is_linear, "None or a function"),
    "version": (lambda value: isinstance(value, str), "text"),
}
_ESTIMATOR: Final[_Rules] = {
    "name": (_is_text, "text in one line"),
    "start": (callable, "a function or a class"),
}


def why_refused(record: Law | Estimator) -> str | None:
    """Return in a line why a record cannot be used, by its first such field; None if it can."""
    for name, value, allowed in _refused(record):
        return f"{name} is {shortened(value)}; allowed: {allowed}"
    return None


def _refused(record: Law | Estimator) -> Iterator[_Refused]:
    for name, (is_valid, allowed) in (_LAW if isinstance(record, Law) else _ESTIMATOR).items():
        value = getattr(record, name)
        if not is_valid(value):
            yield _Refused(name, value, allowed)
    yield from _in_parameters(record.parameters)
    if isinstance(record, Law):
        yield from _in_needs(record.needs, [one.name for one in fields(record.parameters)])


def _in_parameters(parameters: Any) -> Iterator[_Refused]:
    if not (isinstance(parameters, type) and is_dataclass(parameters)):
        yield _Refused("parameters", parameters, "a dataclass (the class itself)")
        return
    try:
        with errors_of_the_code(lambda error: _ParametersError(described(error))):
            why = _why_no_parameters(parameters)
    except _ParametersError as error:
        why = str(error)
    if why:
        allowed = f"a dataclass of numbers, text and tuples ({why})"
        yield _Refused("parameters", parameters, allowed)


def _why_no_parameters(parameters: type) -> str | None:
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


def _in_needs(needs: Any, parameters: list[str]) -> Iterator[_Refused]:
    if not isinstance(needs, Needs):
        yield _Refused("needs", needs, "Needs(…)")
        return
    is_count = type(needs.sides) is int and 0 <= needs.sides <= _MOST_SIDES
    if not (is_count or needs.sides in parameters):
        allowed = f"0 to {_MOST_SIDES}, or the name of a parameter"
        yield _Refused("needs.sides", needs.sides, allowed)
    if not (isinstance(needs.commands, bool) or needs.commands in parameters):
        allowed = "True, False, or the name of a parameter"
        yield _Refused("needs.commands", needs.commands, allowed)
