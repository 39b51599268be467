"""`make docs` makes the tables of keys in docs/scenarios.md, and its JSON Schema.

A table stands below the heading of its section, such as "### `channel.loss`". The text around it
is written by hand.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

from zenvoy.laws import builtin
from zenvoy.scenarios.reading.allowed import interval, resolved
from zenvoy.scenarios.reading.editor_schema import editor_schema
from zenvoy.scenarios.schema.meanings import documented_schema

DOCS: Final = Path(__file__).parents[1] / "docs"
PAGE: Final = DOCS / "scenarios.md"
SCHEMA: Final = DOCS / "scenario.schema.json"

UNITS: Final = {
    "m": "m",
    "s": "s",
    "ms": "ms",
    "mps": "m/s",
    "mps2": "m/s²",
    "mps3": "m/s³",
    "hz": "Hz",
    "ghz": "GHz",
    "mbps": "Mbit/s",
    "bytes": "bytes",
    "dbm": "dBm",
    "db": "dB",
    "d": "s⁻²",  # of the gains
    "v": "s⁻¹",
    "c": "s⁻¹",
}
_HEAD: Final = "| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n"


class Row(NamedTuple):
    """A key of a section, and what the reference says of it."""

    section: str
    key: str
    unit: str
    default: str
    allowed: str
    meaning: str

    def __str__(self) -> str:
        cells = (f"`{self.key}`", self.unit, self.default, self.allowed, self.meaning)
        return "| " + " | ".join(cells).replace("|  |", "| |") + " |"


def rows() -> list[Row]:
    """Return a row for each key of the schema, in its order."""
    schema = documented_schema()
    return list(_rows(schema, "", schema["$defs"]))


def _rows(schema: dict[str, Any], section: str, sections: dict[str, Any]) -> Iterator[Row]:
    for key, declared in schema["properties"].items():
        path, value = f"{section}.{key}".lstrip("."), resolved(declared, sections)
        has_keys = "properties" in value and "nullable" not in value
        if "noun" in value or not has_keys:
            words = declared.get("description", "")
            allowed, default = _allowed(value), _default(schema, key, value)
            yield Row(section, key, _unit(key), default, allowed, words)
        if has_keys:
            yield from _rows(value, path, sections)
            continue
        items = resolved(value.get("items", {}), sections)
        if "properties" in items:
            yield from _rows(items, path, sections)
        for branch in items.get("oneOf", ()):
            of_type = resolved(branch, sections)
            yield from _rows(of_type, of_type["properties"]["type"]["const"], sections)


def _unit(key: str) -> str:
    _, underscore, suffix = key.rpartition("_")
    return UNITS.get(suffix, "") if underscore else ""


def _default(schema: dict[str, Any], key: str, value: dict[str, Any]) -> str:
    of_other_events = key == "type" and value.get("const", "brake") != "brake"
    if of_other_events or key in schema.get("required", ()):
        return "required"
    if "default" not in value:
        return "–"
    default = value["default"]
    if value.get("type") == "object" and default == []:
        default = {}  # a mapping is kept as pairs
    plain = isinstance(default, str) and default
    return f"`{default}`" if plain else f"`{json.dumps(default)}`"


def _allowed(value: dict[str, Any]) -> str:
    if "const" in value:
        return str(value["const"])
    kinds = {"string": "text", "array": "list", "boolean": "true, false", "object": "mapping"}
    choice = ", ".join(value.get("enum", ()))
    if value.get("enum") == list(builtin()):
        choice = "a [control law](laws.md)"
    words = (
        choice or value.get("noun") or interval(value).removeprefix("in ") or kinds[value["type"]]
    )
    return f"{words} or null" if "nullable" in value else words


def page() -> str:
    """Return docs/scenarios.md with the tables of keys as they should be.

    Raises LookupError if a section has no table under its heading.
    """
    text, of_sections = PAGE.read_text(encoding="utf-8"), rows()
    for section in dict.fromkeys(row.section for row in of_sections):
        table = "".join(f"{row}\n" for row in of_sections if row.section == section)
        heading = f"### `{section}`" if section else "## Top level"
        below = re.search(
            rf"^{re.escape(heading)}\n(?:(?!#).*\n)*?{re.escape(_HEAD)}((?:\|.*\n)*)", text, re.M
        )
        if below is None:
            raise LookupError(f"{PAGE.name}: no table of keys below {heading}")
        text = text[: below.start(1)] + table + text[below.end(1) :]
    return text


def schema_file() -> str:
    """Return docs/scenario.schema.json as it should be."""
    return json.dumps(editor_schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    SCHEMA.write_text(schema_file(), encoding="utf-8")
