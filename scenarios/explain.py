"""What pydantic refuses, in our words: what was written, and what is allowed there."""

from __future__ import annotations

from difflib import get_close_matches
from typing import NamedTuple

from pydantic_core import ErrorDetails

from zenvoy.scenarios.allowed import JsonSchema, interval, noun, path_of, schema_at, types
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.tree import Node, Path, Unreadable
from zenvoy.scenarios.wording import dotted, one_line, shown, trimmed

_OUT_OF_RANGE = {
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
    "finite_number",
}


class Refusal(NamedTuple):
    """What pydantic refuses: the value at a path into the file, and the schema there.

    Of an unknown key, the schema is that of the mapping it is in.
    """

    path: Path
    kind: str
    value: object
    schema: JsonSchema


def refusal(error: ErrorDetails) -> Refusal:
    """The refusal behind one entry of ValidationError.errors()."""
    loc, kind, value = error["loc"], error["type"], error["input"]
    if kind == "extra_forbidden":
        return Refusal((*path_of(loc[:-1]), loc[-1]), kind, value, schema_at(loc[:-1]))
    return Refusal(path_of(loc), kind, value, schema_at(loc))


def explained(refused: Refusal, root: Node) -> Problem | None:
    """The problem that a refusal is, with its place in `root`.

    None if the value could not even be read: that is reported where it was tried.
    """
    path, kind, value, schema = refused = _narrowed(refused)
    if kind == "extra_forbidden":
        text = _unknown_key(str(path[-1]), list(schema["properties"]))
    elif value is Unreadable.UNREADABLE:
        return None
    else:
        text = _refused_value(refused)
    return Problem(key=dotted(path), text=text, place=root.place_of(path))


def _narrowed(refused: Refusal) -> Refusal:
    """Of an entry whose type is none that there is, the type alone."""
    path, kind, value, schema = refused
    if kind.startswith("union_tag") and isinstance(value, dict):
        return Refusal((*path, "type"), kind, value.get("type"), {"enum": types(schema)})
    return refused


def nearest(name: str, names: list[str]) -> str:
    """A hint at the likeliest of `names`, which ends in a space, or nothing."""
    near = get_close_matches(name, names, n=1)
    return f"did you mean {one_line(near[0])!r}? " if near else ""


def _unknown_key(key: str, allowed: list[str]) -> str:
    return f"unknown key; {nearest(key, allowed)}allowed: {', '.join(allowed)}"


def _refused_value(refused: Refusal) -> str:
    _, kind, value, schema = refused
    if kind == "missing":
        return f"missing; allowed: {noun(schema)} {interval(schema)}".rstrip()
    if kind in _OUT_OF_RANGE:
        return f"{shown(value)} is not {interval(schema)}"
    if isinstance(value, list) and kind == "too_long":
        return f"a list of {len(value)} is not {noun(schema)}"
    if schema.get("type") == "integer" and isinstance(value, float) and value.is_integer():
        return f"{shown(value)} is not a whole number; write {trimmed(value)}"
    return f"{shown(value)} is not {noun(schema)}"
