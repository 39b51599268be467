"""Turns errors of pydantic into messages: what was written, and what is allowed there."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Final, NamedTuple

from pydantic_core import ErrorDetails

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.reading.allowed import JsonSchema, interval, noun, path_of, schema_at, types
from zenvoy.scenarios.reading.tree import Node, Path, Unreadable
from zenvoy.values.wording import dotted, one_line, shown, shown_list, trimmed

_LONGEST_KEY: Final = 100  # the search for similar keys takes longer for longer keys

_OUT_OF_RANGE = {
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
    "finite_number",
}


class Refusal(NamedTuple):
    """A value that pydantic refuses, its path in the file, and the schema there.

    For an unknown key, the schema is that of the mapping around it.
    """

    path: Path
    kind: str
    value: object
    schema: JsonSchema


def refusal(error: ErrorDetails) -> Refusal:
    """Return the refusal that an entry of ValidationError.errors() describes."""
    loc, kind, value = error["loc"], error["type"], error["input"]
    if kind == "extra_forbidden":
        return Refusal((*path_of(loc[:-1]), loc[-1]), kind, value, schema_at(loc[:-1]))
    return Refusal(path_of(loc), kind, value, schema_at(loc))


def is_reported(refused: Refusal) -> bool:
    """Return whether the value could not be read, which is reported already."""
    return refused.kind != "extra_forbidden" and (_narrowed(refused).value is Unreadable.UNREADABLE)


def explained(refused: Refusal, root: Node) -> Problem:
    """Return a refusal as a problem with its place in `root`."""
    path, kind, _, schema = refused = _narrowed(refused)
    if kind == "extra_forbidden":
        text = _unknown_key(str(path[-1]), list(schema["properties"]))
    else:
        written = root.find(path)
        if written is not None and isinstance(written.value, str):  # show 150% instead of 1.5
            refused = refused._replace(value=written.value)
        text = _refused_value(refused)
    return Problem(key=dotted(path), text=text, place=root.place_of(path))


def _narrowed(refused: Refusal) -> Refusal:
    """Reduce the refusal of an entry with an unknown type to its type."""
    path, kind, value, schema = refused
    if kind.startswith("union_tag") and isinstance(value, dict):
        return Refusal((*path, "type"), kind, value.get("type"), {"enum": types(schema)})
    return refused


def nearest(name: str, names: Mapping[str, str]) -> str:
    """Return a hint at the most similar name, with a space at its end, or "".

    `names` maps each spelling to a name.
    """
    near = _near(name, names) or _near(name.lower(), names)
    return f"did you mean {one_line(names[near[0]])!r}? " if near else ""


def _near(name: str, names: Mapping[str, str]) -> list[str]:
    """Return the most similar of `names`, if any is similar enough.

    difflib matches the longest common part first, which is not always the best choice: "momo" is
    similar to "mimo" only if both are read backwards.
    """
    backwards = get_close_matches(name[::-1], [other[::-1] for other in names], n=1)
    return get_close_matches(name, names, n=1) or [other[::-1] for other in backwards]


def _unknown_key(key: str, allowed: list[str]) -> str:
    hint = nearest(key[:_LONGEST_KEY], {name: name for name in allowed})
    return f"unknown key; {hint}allowed: {', '.join(allowed)}"


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
    return f"{_shown(value, schema)} is not {noun(schema)}"


def _shown(value: object, schema: JsonSchema) -> str:
    """Return a value as text; a list with its entries if a list is allowed."""
    lists = any(form.get("type") == "array" for form in schema.get("forms", ()))
    return shown_list(value) if lists and isinstance(value, list | tuple) else shown(value)
