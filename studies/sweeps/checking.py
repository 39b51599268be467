"""Checks a mapping against a schema; a problem has its key, value, place, and what is allowed."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from zenvoy.scenarios import Problem
from zenvoy.scenarios.reading.explain import nearest
from zenvoy.scenarios.reading.tree import Node, Path
from zenvoy.values.section import Section
from zenvoy.values.wording import dotted, shown

_LONGEST_NAME = 100  # the search for similar names takes longer for longer names

Kind = TypeVar("Kind", bound=Section)


def checked(kind: type[Kind], node: Node, path: Path) -> tuple[Kind | None, list[Problem]]:
    """Return the section that a node at `path` describes, or None and its problems.

    The `description` of each field says what is allowed there.
    """
    try:
        return kind.model_validate(node.plain()), []
    except ValidationError as refused:
        found: dict[str, Problem] = {}  # of a union, each branch has an error for the same key
        for error in refused.errors(include_url=False):
            problem = _explained(error, kind, node, path)
            found.setdefault(problem.key, problem)
        return None, list(found.values())


def entries(node: Node | None) -> dict[str, Node]:
    """Return the entries of a mapping; none if there is no mapping."""
    return node.value if node is not None and isinstance(node.value, dict) else {}


def unknown(name: str, known: list[str]) -> str:
    """Return what is wrong with an unknown name, with the most similar one."""
    hint = nearest(name[:_LONGEST_NAME], {one: one for one in known})
    return f"unknown name {shown(name)}; {hint}allowed: {', '.join(known)}"


def wrong_names(
    key: str, names: Iterable[str], known: Mapping[str, object], root: Node
) -> Iterator[Problem]:
    """Yield a problem for each name in the list at `key` that is not known, or given twice."""
    names = list(names)
    for number, name in enumerate(names):
        if name not in known:
            place = root.place_of((key, number))
            yield Problem(key=f"{key}.{number}", text=unknown(name, list(known)), place=place)
    yield from repeated(key, names, root)


def repeated(
    key: str, values: Iterable[object], root: Node, path: tuple[str, ...] | None = None
) -> Iterator[Problem]:
    """Yield a problem for each value in a list that is given again.

    The list is at `path` below `root`, by default at `key`.
    """
    seen: set[str] = set()
    for number, value in enumerate(values):
        text = json.dumps(value, sort_keys=True)
        if text in seen:
            place = root.place_of((*(path or (key,)), number))
            what = f"{shown(value)} is given twice; allowed: once"
            yield Problem(key=f"{key}.{number}", text=what, place=place)
        seen.add(text)


def _explained(error: ErrorDetails, kind: type[Section], node: Node, path: Path) -> Problem:
    inside = _written(error["loc"], node)
    if error["type"] == "extra_forbidden":
        known = [field.alias or name for name, field in kind.model_fields.items()]
        name = str(error["loc"][-1])
        hint = nearest(name[:_LONGEST_NAME], {one: one for one in known})
        text = f"unknown key; {hint}allowed: {', '.join(known)}"
    else:
        allowed = _allowed(str(error["loc"][0]) if error["loc"] else "", kind)
        if error["type"] == "missing":
            inside, text = error["loc"], f"missing; allowed: {allowed}"
        else:
            written = node.find(inside)
            value = error["input"] if written is None else written.plain()
            text = f"{shown(value)} is not {allowed}"
    place = node.place_of(inside)
    return Problem(key=dotted((*path, *inside)), text=text, place=place)


def _written(loc: Path, node: Node) -> Path:
    """Return the part of a path of pydantic that is in the file, without names of branches."""
    inside: Path = ()
    for step in loc:
        if node.find((*inside, step)) is not None:
            inside = (*inside, step)
    return inside


def _allowed(name: str, kind: type[Section]) -> str:
    for field_name, field in kind.model_fields.items():
        if name in (field.alias, field_name):
            return field.description or "allowed"
    return "a mapping"
