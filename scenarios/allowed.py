"""What the schema allows at a path, in words."""

from __future__ import annotations

from functools import cache
from typing import Any

from zenvoy.scenarios.schema import Scenario
from zenvoy.scenarios.tree import Path
from zenvoy.scenarios.wording import trimmed

JsonSchema = dict[str, Any]

_NOUNS = {
    "integer": "a whole number",
    "number": "a number",
    "string": "text",
    "array": "a list",
    "object": "a mapping",
}


@cache
def _root_schema() -> JsonSchema:
    return Scenario.model_json_schema()


def schema_at(path: Path) -> JsonSchema:
    """The JSON schema of the value at `path`; where null is allowed too, that of the other values.

    Raises KeyError if the schema has no such path.
    """
    schema = _root_schema()
    for step in path:
        schema = schema["items"] if isinstance(step, int) else schema["properties"][step]
        nullable = "anyOf" in schema
        if nullable:
            schema = schema["anyOf"][0]
        if "$ref" in schema:
            schema = _root_schema()["$defs"][schema["$ref"].rpartition("/")[2]]
        if nullable:
            schema = {**schema, "nullable": True, "default": None}
    return schema


def noun(schema: JsonSchema) -> str:
    """The type, or the values to choose from: "a whole number", "one of ring, open"."""
    if "noun" in schema:
        return f"{schema['noun']} or null" if "nullable" in schema else str(schema["noun"])
    if "const" in schema:
        return str(schema["const"])
    if "enum" in schema:
        return f"one of {', '.join(schema['enum'])}"
    words = _NOUNS[schema["type"]]
    if "properties" in schema:
        words += f"; allowed keys: {', '.join(schema['properties'])}"
    return f"{words} or null" if "nullable" in schema else words


def interval(schema: JsonSchema) -> str:
    """The range of a number: "in [0, 1)" or "at least 1"; empty for what is no number."""
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
    """A value that is valid by itself: the default, or for a required value any."""
    if "default" in schema:
        return schema["default"]
    if "properties" in schema:
        required = schema.get("required", [])
        return {key: stand_in(schema["properties"][key]) for key in required}
    if "enum" in schema:
        return schema["enum"][0]
    return "a" if schema["type"] == "string" else 1
