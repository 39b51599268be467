"""The JSON schema of scenario files, with which an editor completes, explains and checks them.

It allows each form in which a value may be written. What sections say about each other, and what
depends on other files, only `zenvoy check` knows.
"""

from __future__ import annotations

from typing import Any, Final

from zenvoy.scenarios.schema.meanings import documented_schema

_PERCENT: Final = {
    "type": "string",
    "pattern": r"^\s*[+-]?([0-9]{1,20}\.?[0-9]{0,20}|\.[0-9]{1,20})\s*%\s*$",
}
_INTERNAL: Final = {"title", "noun", "own", "forms", "percent"}


def editor_schema() -> dict[str, Any]:
    """Return the schema, in draft 2020-12 of JSON Schema."""
    schema = _written(documented_schema())
    assert isinstance(schema, dict)
    _name_types(schema)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A scenario of Zenvoy",
        **schema,
        "patternProperties": {"^x-": True},
    }


def _name_types(schema: dict[str, Any]) -> None:
    """Require the type of each event but a brake, and of each fault; a brake may leave it out."""
    for key in ("events", "faults"):
        for branch in schema["properties"][key]["items"]["oneOf"]:
            section = schema["$defs"][branch["$ref"].rpartition("/")[2]]
            if section["properties"]["type"].get("default") != "brake":
                section["required"] = sorted({"type", *section.get("required", ())})


def _written(schema: Any) -> Any:
    """Return a part of the schema as files are written: see `forms` in `schema.inputs`."""
    if isinstance(schema, list):
        return [_written(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    plain = {key: _written(part) for key, part in schema.items() if key not in _INTERNAL}
    if "properties" in schema:  # whose keys may have any name
        plain["properties"] = {key: _written(part) for key, part in schema["properties"].items()}
    if "default" in schema:
        plain["default"] = schema["default"]
    beside = {key: plain[key] for key in ("description", "default") if key in plain}
    if "forms" in schema:
        mapping = [{"$ref": schema["$ref"]}] if "$ref" in schema else []
        return {**beside, "anyOf": [*schema["forms"], *mapping]}
    if "percent" in schema:
        number = {key: part for key, part in plain.items() if key not in beside}
        return {**beside, "anyOf": [number, _PERCENT]}
    return plain
