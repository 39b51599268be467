"""Describes in words what the schema allows at a path."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

from zenvoy.scenarios.reading.tree import Path
from zenvoy.scenarios.schema.scenario import Scenario
from zenvoy.values.wording import trimmed

JsonSchema = dict[str, Any]

_COLUMNS: Final = 9  # no list has more entries of different schemas

_TO_RESOLVE = {"$ref", "anyOf"}
_NULL = {"type": "null"}

_NOUNS = {
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "string": "text",
    "array": "a list",
    "object": "a mapping",
}


@cache
def _root_schema() -> JsonSchema:
    return Scenario.model_json_schema()


def schema_at(loc: Path) -> JsonSchema:
    """Return the JSON schema at `loc`, a path as in pydantic's errors, resolved.

    If entries of a list have several types, `loc` may name one after the entry's index. Raises
    KeyError if the schema has no such path.
    """
    return _walk(_shape(loc))[0]


def path_of(loc: Path) -> Path:
    """Return `loc`, a path as in pydantic's errors, without the names of entry types."""
    return tuple(step for step, named in zip(loc, _walk(_shape(loc))[1], strict=True) if named)


def _shape(loc: Path) -> Path:
    """Return `loc` with large indices cut, because entries beyond a few share one schema."""
    return tuple(min(step, _COLUMNS) if isinstance(step, int) else step for step in loc)


@cache
def _walk(loc: Path) -> tuple[JsonSchema, tuple[bool, ...]]:
    """Return the schema at `loc`, and for each step whether it is a step into the file."""
    schema = _root_schema()
    named: list[bool] = []
    for step in loc:
        if "oneOf" in schema and not isinstance(step, int):
            branches = map(resolved, schema["oneOf"])
            schema = next(b for b in branches if b["properties"]["type"]["const"] == step)
            named.append(False)
            continue
        named.append(True)
        if not isinstance(step, int):
            schema = resolved(schema["properties"][step])
        elif "prefixItems" in schema:
            schema = resolved(schema["prefixItems"][step])
        else:
            schema = resolved(schema["items"])
    return schema, tuple(named)


def resolved(schema: JsonSchema, sections: JsonSchema | None = None) -> JsonSchema:
    """Return the schema with references and "or null" replaced by the schema they stand for.

    sections: the schema of each section by name; None: those of a scenario.
    """
    sections = _root_schema()["$defs"] if sections is None else sections
    while not _TO_RESOLVE.isdisjoint(schema):
        if "$ref" in schema:
            beside = {key: value for key, value in schema.items() if key != "$ref"}
            schema = {**sections[schema["$ref"].rpartition("/")[2]], **beside}
            continue
        first = next(branch for branch in schema["anyOf"] if branch != _NULL)
        schema = {"default": None, **schema, **resolved(first, sections), "nullable": True}
        del schema["anyOf"]
    return schema


def types(schema: JsonSchema) -> list[str]:
    """Return the types that an entry can have; empty if there is only one."""
    return [resolved(b)["properties"]["type"]["const"] for b in schema.get("oneOf", ())]


def noun(schema: JsonSchema) -> str:
    """Return the type or the choices: "a whole number", "one of ring, open"."""
    if "own" in schema:
        names = [*schema["enum"], *(["null"] if "nullable" in schema else [])]
        return f"one of {', '.join(names)}, or {schema['own']}"
    return f"{_noun(schema)} or null" if "nullable" in schema else _noun(schema)


def _noun(schema: JsonSchema) -> str:
    if "noun" in schema:
        return str(schema["noun"])
    if "const" in schema:
        return str(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(schema['enum'])}"
    if kinds := types(schema):
        return f"a mapping; its type: one of {', '.join(kinds)}"
    words = _NOUNS[schema["type"]]
    if "prefixItems" in schema:
        words += f" of {len(schema['prefixItems'])}"
    if "properties" in schema:
        words += f"; allowed keys: {', '.join(schema['properties'])}"
    return words


def interval(schema: JsonSchema) -> str:
    """Return the range of a number: "in [0, 1)" or "at least 1"; "" for other types."""
    if not {"minimum", "exclusiveMinimum"} & schema.keys():
        return ""
    if "exclusiveMinimum" in schema:
        low = f"({trimmed(schema['exclusiveMinimum'])}"
    else:
        low = f"[{trimmed(schema['minimum'])}"
    if "maximum" in schema:
        return f"in {low}, {trimmed(schema['maximum'])}]"
    if "exclusiveMaximum" in schema:
        return f"in {low}, {trimmed(schema['exclusiveMaximum'])})"
    return f"at least {low[1:]}"


def stand_in(schema: JsonSchema) -> object:
    """Return a value that is valid by itself: the default, or any value if there is none."""
    if "default" in schema:
        return schema["default"]
    if "oneOf" in schema:
        return stand_in(resolved(schema["oneOf"][0]))
    if "properties" in schema:
        required = schema.get("required", [])
        return {key: stand_in(resolved(schema["properties"][key])) for key in required}
    if "enum" in schema:
        return schema["enum"][0]
    if schema["type"] == "array":
        return [stand_in(resolved(item)) for item in schema.get("prefixItems", ())]
    return "a" if schema["type"] == "string" else 1
