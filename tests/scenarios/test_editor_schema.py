"""The JSON Schema for editors allows every valid scenario, and marks what `check` refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final

import pytest
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML

from tests.conftest import zenvoy
from tests.mutants import mutant
from zenvoy.scenarios import ScenarioError, load
from zenvoy.scenarios.reading.editor_schema import editor_schema
from zenvoy.scenarios.reading.library import packaged

SCHEMA: Final = editor_schema()
VALIDATOR: Final = Draft202012Validator(SCHEMA)
DOCS: Final = Path(__file__).parents[2] / "docs"
EXAMPLES: Final = [
    text
    for page in sorted(DOCS.glob("*.md"))
    for text in re.findall(r"```yaml\n(.*?)```", page.read_text(), re.DOTALL)
    if re.search(r"^(extends|fleet|channel|control|faults|events|sensors):", text, re.MULTILINE)
]


def marks(text: str) -> list[str]:
    """Return the places that an editor marks."""
    values: Any = YAML(typ="safe", pure=True).load(text)
    return [error.json_path for error in VALIDATOR.iter_errors(values or {})]


def test_it_is_a_json_schema(tmp_path: Path) -> None:
    Draft202012Validator.check_schema(SCHEMA)
    printed = zenvoy(tmp_path, "schema")
    assert (printed.code, json.loads(printed.out)) == (0, SCHEMA)


@pytest.mark.parametrize("name", packaged())
def test_built_in_scenarios_have_no_marks(name: str) -> None:
    assert marks(packaged()[name].read_text()) == []


@pytest.mark.parametrize("text", EXAMPLES)
def test_examples_of_the_documentation_have_no_marks(text: str) -> None:
    assert marks(text) == []


def test_nothing_that_loads_has_a_mark(tmp_path: Path) -> None:
    path, loaded = tmp_path / "mutant.yaml", 0
    for number in range(200):
        text = mutant(number)
        path.write_bytes(text.encode())
        try:
            load(path)
        except ScenarioError:
            continue
        assert marks(text) == [], text
        loaded += 1
    assert loaded > 30


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("flete: {size: 3}", "$"),
        ("fleet: {size: 1}", "$.fleet.size"),
        ("fleet: {size: 3, sise: 4}", "$.fleet"),
        ("channel: {loss: {p: 1.4}}", "$.channel.loss.p"),
        ("channel: {loss: {p: most}}", "$.channel.loss.p"),
        ("channel: {technology: 7}", "$.channel.technology"),
        ("control: {model: PCM}", "$.control.model"),
        ("estimator: {kind: kf2}", "$.estimator.kind"),
        ("control: {multi_node: {weights: best}}", "$.control.multi_node.weights"),
        ("clock: fast", "$.clock"),
        ("events: [{vehicle: 3, at_s: 1}]", "$.events[0]"),
        ("events: [{type: sin, vehicle: 3, at_s: 1}]", "$.events[0]"),
        ("faults: [{vehicles: 3, at_s: 1}]", "$.faults[0]"),
    ],
)
def test_what_is_refused_has_a_mark(text: str, place: str) -> None:
    assert marks(text) == [place]


@pytest.mark.parametrize(
    "text",
    [
        "channel: {loss: {p: 5 %}}",
        "control: {model: mylaws:smith}",
        "channel: {technology: ./mine.yaml}",
        "x-brake: {at_s: 10}",
        "fleet: {groups: [{name: a, vehicles: [1, 4-6]}, {name: b, vehicles: 7}]}",
        "channel: {delay_ms: 10}",
        "channel: {delay_ms: [10, 20]}",
    ],
)
def test_each_form_of_a_value_is_allowed(text: str) -> None:
    assert marks(text) == []


def test_keys_are_explained() -> None:
    assert SCHEMA["properties"]["seed"]["description"] == "Seed of all random draws."
