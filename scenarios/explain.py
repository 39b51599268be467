"""What pydantic refuses, in our words: what was written, and what is allowed there."""

from __future__ import annotations

from difflib import get_close_matches

from pydantic_core import ErrorDetails

from zenvoy.scenarios.allowed import interval, noun, schema_at
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.tree import Node, Path
from zenvoy.scenarios.wording import dotted, one_line, shown, trimmed

_OUT_OF_RANGE = {
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
    "finite_number",
}


def explained(error: ErrorDetails, root: Node) -> Problem:
    """The problem behind one entry of ValidationError.errors(), with its place in `root`."""
    path = error["loc"]
    if error["type"] == "extra_forbidden":
        text = _unknown_key(str(path[-1]), list(schema_at(path[:-1])["properties"]))
    else:
        text = _refused_value(error["type"], error["input"], path)
    return Problem(key=dotted(path), text=text, place=root.place_of(path))


def nearest(name: str, names: list[str]) -> str:
    """A hint at the likeliest of `names`, which ends in a space, or nothing."""
    near = get_close_matches(name, names, n=1)
    return f"did you mean {one_line(near[0])!r}? " if near else ""


def _unknown_key(key: str, allowed: list[str]) -> str:
    return f"unknown key; {nearest(key, allowed)}allowed: {', '.join(allowed)}"


def _refused_value(kind: str, value: object, path: Path) -> str:
    schema = schema_at(path)
    if kind == "missing":
        return f"missing; allowed: {noun(schema)} {interval(schema)}".rstrip()
    if kind in _OUT_OF_RANGE:
        return f"{shown(value)} is not {interval(schema)}"
    if schema["type"] == "integer" and isinstance(value, float) and value.is_integer():
        return f"{shown(value)} is not a whole number; write {trimmed(value)}"
    return f"{shown(value)} is not {noun(schema)}"
