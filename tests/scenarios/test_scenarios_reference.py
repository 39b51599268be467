"""docs/scenarios.md has exactly one row for every key of the schema, and its examples load."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import pytest

from tests import recordings
from zenvoy.laws import builtin
from zenvoy.scenarios import load
from zenvoy.scenarios.reading.allowed import interval, resolved, schema_at, types

PAGE: Final = (Path(__file__).parents[2] / "docs" / "scenarios.md").read_text()

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
    "d": "s⁻²",  # of the gains
    "v": "s⁻¹",
    "c": "s⁻¹",
}


class Row(NamedTuple):
    """A key, below its section, and what the reference must say of it."""

    section: str
    key: str
    unit: str
    default: str
    allowed: str

    def __str__(self) -> str:
        cells = (f"`{self.key}`", self.unit, self.default, self.allowed, "…")
        return f"under {self.section or 'the whole'}: | {' | '.join(cells)} |".replace(
            "|  |", "| |"
        )


def rows_of_schema(schema: dict[str, Any], section: str) -> Iterator[Row]:
    for key, declared in schema["properties"].items():
        path, value = f"{section}.{key}".lstrip("."), resolved(declared)
        if "noun" in value and "properties" in value:  # a name, or a mapping
            yield Row(section, key, _unit(key), _default(schema, key, value), _allowed(value))
        if "properties" in value and "nullable" not in value:
            yield from rows_of_schema(value, path)
            continue
        yield Row(section, key, _unit(key), _default(schema, key, value), _allowed(value))
        items = resolved(value.get("items", {}))
        if "properties" in items:
            yield from rows_of_schema(items, path)
        for kind in types(items):
            yield from rows_of_schema(schema_at((path, 0, kind)), kind)


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
        choice = "a law of [laws.md](laws.md)"
    words = (
        choice or value.get("noun") or interval(value).removeprefix("in ") or kinds[value["type"]]
    )
    return f"{words} or null" if "nullable" in value else words


def rows_of_page() -> Iterator[Row]:
    section = ""
    for line in PAGE.splitlines():
        if heading := re.match(r"#+ (.*)", line):
            named = re.fullmatch(r"`(.*)`", heading[1])
            section = named[1] if named else ""
        elif re.match(r"\| `\S+` \|", line) and line.count("|") == 6:
            key, unit, default, allowed = (cell.strip() for cell in line.split("|")[1:5])
            yield Row(section, key.strip("`"), unit, default, allowed)


def test_every_key_has_a_correct_row_and_there_are_no_others() -> None:
    written, expected = list(rows_of_page()), list(rows_of_schema(schema_at(()), ""))
    assert len(set(written)) == len(written)
    missing = [str(row) for row in expected if row not in written]
    outdated = [str(row) for row in written if row not in expected]
    assert (missing, outdated) == ([], [])
    assert len(expected) > 40


BLOCKS: Final = re.findall(r"```(yaml|csv)\n(.*?)```", PAGE, re.S)


@pytest.mark.parametrize("text", [text for kind, text in BLOCKS if kind == "yaml"])
def test_the_examples_load(tmp_path: Path, text: str) -> None:
    (tmp_path / "s.yaml").write_text(text)
    (tmp_path / "drive.csv").write_text(next(text for kind, text in BLOCKS if kind == "csv"))
    (tmp_path / "openacc.csv").write_text(recordings.OPENACC)
    (tmp_path / "fcd.csv").write_text(recordings.FCD)
    (tmp_path / "epa.txt").write_text(recordings.EPA)
    load(tmp_path / "s.yaml")
