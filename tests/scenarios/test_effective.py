"""A scenario with all its values is written as YAML and as JSON, and read back."""

from __future__ import annotations

import json

import pytest

from tests.scenarios.conftest import Write
from zenvoy.scenarios import (
    Scenario,
    effective_json,
    effective_yaml,
    load,
)


def test_the_effective_yaml_has_every_value_in_the_order_of_the_schema(write: Write) -> None:
    scenario = load("paper/case-15").scenario
    text = effective_yaml(scenario)
    top = [line.partition(":")[0] for line in text.splitlines() if line[0] not in " -"]
    assert top == list(Scenario.model_fields)
    assert "  bit_rate_mbps: null\n" in text
    assert load(write(text)).scenario == scenario


@pytest.mark.parametrize(
    "description",
    [
        "",
        "yes",
        "null",
        "1e3",
        ".5e3",
        "a: b",
        "# c",
        " d ",
        "\x85",
        "\u2028",
        "\r\n",
        "é😀",
        "x " * 99,
    ],
)
def test_any_description_is_written_and_read_back(write: Write, description: str) -> None:
    scenario = Scenario(description=description)
    assert load(write(effective_yaml(scenario))).scenario == scenario


def test_the_effective_yaml_quotes_no_plain_words() -> None:
    lines = effective_yaml(Scenario(description="3")).splitlines()
    assert [line for line in lines if '"' in line] == [
        'description: "3"',
        '    title: "IEEE 802.11p"',
        '    bandwidth: "10 MHz"',
        '    bit_rate: "3 to 27 Mbit/s"',
    ]


def test_the_effective_json_is_sorted_and_read_back() -> None:
    scenario = load("quickstart").scenario
    text = effective_json(scenario)
    values = json.loads(text)
    assert list(values) == sorted(Scenario.model_fields)
    assert list(values["sensors"]) == ["distribution", "error", "position_std_m"]
    assert Scenario.model_validate_json(text) == scenario
    assert effective_json(Scenario(duration_s=60)) == effective_json(Scenario(duration_s=60.0))
