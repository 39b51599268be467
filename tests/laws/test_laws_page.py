"""docs/laws.md lists every law, with the parameters it really has."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Final, NamedTuple

import pytest

from zenvoy.laws import Law, builtin
from zenvoy.laws.parameters import model_of
from zenvoy.scenarios.reading.allowed import interval

PAGE: Final = (Path(__file__).parents[2] / "docs" / "laws.md").read_text()
UNITS: Final = {"_per_s": "s⁻¹", "_mps2": "m/s²", "_mps": "m/s", "_s": "s", "_m": "m"}
WITH_PARAMETERS: Final = [
    law.name for law in builtin().values() if law.section is None and fields(law.parameters)
]


class Row(NamedTuple):
    """A parameter, and what the page must say of it."""

    name: str
    unit: str
    default: str
    allowed: str


def rows_of_law(law: Law) -> Iterator[Row]:
    for name, value in model_of(law.parameters).model_json_schema()["properties"].items():
        unit = next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")
        default = f"`{json.dumps(value['default'])}`"
        yield Row(name, unit, default, interval(value).removeprefix("in "))


def rows_of_page(name: str) -> Iterator[Row]:
    (section,) = re.findall(rf"^## {re.escape(name)}\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S)
    for line in section.splitlines():
        if re.match(r"\| `\w+` \|", line):
            parameter, unit, default, allowed = (cell.strip() for cell in line.split("|")[1:5])
            yield Row(parameter.strip("`"), unit, default, allowed)


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_the_parameters_of_a_law_are_those_of_the_page(name: str) -> None:
    assert list(rows_of_page(name)) == list(rows_of_law(builtin()[name]))


def test_the_table_has_every_law() -> None:
    table = PAGE.partition("\n## ")[0]
    named = re.findall(r"^\| \[?(\w[\w-]*)\]?(?:\(#\S+\))? \|", table, re.M)
    assert named == ["model", *builtin()]
