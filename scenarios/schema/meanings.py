"""The JSON schema of a scenario with the meaning of each key, as it stands below the key.

The meanings are docstrings of fields. Python does not keep those, and pydantic would read the
source of every section at each start to find them. They are read here, when somebody asks.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from textwrap import dedent
from typing import Any, get_args, get_type_hints

from zenvoy.scenarios.schema.scenario import Scenario
from zenvoy.values.section import Section


def documented_schema() -> dict[str, Any]:
    """Return the JSON schema of a scenario, in which each key has a description."""
    schema = Scenario.model_json_schema()
    of_sections = {"Scenario": schema, **schema["$defs"]}
    for section in _sections(Scenario):
        properties = of_sections[section.__name__]["properties"]
        for key in section.model_fields.keys() & properties.keys():
            properties[key].setdefault("description", meaning_of(section, key))
    return schema


def meaning_of(section: type[Section], key: str) -> str:
    """Return what a key of a section means, in one line; "" if nothing is said."""
    owners = (base for base in section.__mro__ if issubclass(base, Section))
    return next((words[key] for words in map(_words, owners) if key in words), "")


@cache
def _words(section: type[Section]) -> dict[str, str]:
    """Return the docstring below each field that the section itself declares, by key."""
    [body] = ast.parse(dedent(inspect.getsource(section))).body
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, below in pairwise(body.body):
        match field, below:
            case (
                ast.AnnAssign(target=ast.Name(id=key)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                found[key] = " ".join(text.split())
    return found


def _sections(of: Any) -> Iterator[type[Section]]:
    """Yield the sections in a type, and all sections in their fields."""
    if isinstance(of, type) and issubclass(of, Section):
        yield of
        for hint in get_type_hints(of, include_extras=True).values():
            yield from _sections(hint)
        return
    for part in get_args(of):
        yield from _sections(part)
