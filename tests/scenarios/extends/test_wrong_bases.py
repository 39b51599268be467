"""A message on a value names the file that has it, and a base that is no scenario is refused."""

from __future__ import annotations

import os

import pytest

from tests.scenarios.extends.conftest import BASE, Write, problems
from zenvoy.scenarios import (
    InvalidScenarioError,
    ScenarioError,
    UnreadableScenarioError,
    load,
)


def test_errors_point_to_the_file_that_has_the_value(write: Write) -> None:
    write(
        {
            "base.yaml": "seed: x\n\nfleet:\n  size: 1\n  colour: red\nchannel: {loss: {p: 0}}\n",
            "middle.yaml": "extends: base.yaml\nduration_s: -1\nfleet: {length_m: 0}\n",
            "s.yaml": "extends: middle.yaml\nfleet:\n  gap_m: no\nchannel: {loss: {p: 2}}\n",
        }
    )
    assert problems("period_ms=0") == [
        "seed: 'x' is not a whole number  (base.yaml, line 1)",
        "fleet.size: 1 is not in [2, 10000]  (base.yaml, line 4)",
        "fleet.colour: unknown key; allowed: size, length_m, gap_m, bumper_gap_m, speed_mps, "
        "initial_gaps_m, initial_speeds_mps, reported_gaps, groups"
        "  (base.yaml, line 5)",
        "duration_s: -1 is not in (0, 1e9]  (middle.yaml, line 2)",
        "fleet.length_m: 0 is not in (0, 1e9]  (middle.yaml, line 3)",
        "fleet.gap_m: 'no' is not a number  (s.yaml, line 3)",
        "channel.loss.p: 2 is not in [0, 1]  (s.yaml, line 4)",
        "period_ms: 0 is not in [1, 10000]  (--set period_ms=0)",
    ]


def test_a_disagreement_is_reported_at_the_line_that_causes_it(write: Write) -> None:
    write({"base.yaml": BASE, "s.yaml": "extends: base.yaml\nseed: 1\nfleet: {size: 8}\n"})
    line = "events.0.vehicle: 9 is not in [1, 8], the vehicles of fleet.size (8)"
    assert problems() == [f"{line}  (s.yaml, line 3)"]
    write({"s.yaml": "extends: base.yaml\nseed: 1\n"})
    assert problems("fleet.size=8") == [f"{line}  (--set fleet.size=8)"]
    write({"base.yaml": BASE.replace("size: 9", "size: 8")})
    assert problems() == [f"{line}  (base.yaml, line 8)"]
    assert load("s.yaml", ["fleet.size=9"]).scenario.fleet.size == 9


def test_errors_of_reading_a_base_are_reported_even_if_the_value_is_replaced(write: Write) -> None:
    base = "seed: 1\nseed: 2\nfleet: !dice 6\n"
    write({"base.yaml": base, "s.yaml": "extends: base.yaml\nseed: 3\nfleet: {size: 4}\n"})
    assert problems() == [
        "seed: given twice, first in base.yaml, line 1; allowed: once  (base.yaml, line 2)",
        "fleet: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
        "  (base.yaml, line 3)",
    ]


@pytest.mark.parametrize(
    ("base", "kind", "line"),
    [
        (
            "seed: [1\n",
            UnreadableScenarioError,
            "not valid YAML: while parsing a flow sequence, expected ',' or ']', but got "
            "'<stream end>'  (base.yaml, line 2)",
        ),
        (
            "",
            InvalidScenarioError,
            "empty; allowed: a mapping ({} for the defaults alone)  (base.yaml)",
        ),
        (
            "[1]",
            InvalidScenarioError,
            "a list is not a mapping; the top level must be one  (base.yaml)",
        ),
    ],
)
def test_a_base_that_is_no_scenario_is_refused(
    write: Write, base: str, kind: type[ScenarioError], line: str
) -> None:
    write({"base.yaml": base, "s.yaml": "seed: x\nextends: base.yaml\n"})
    assert problems(kind=kind) == [line]


def test_a_base_without_read_permission_is_refused(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    write({"base.yaml": "seed: 1\n", "s.yaml": "extends: base.yaml\n"})
    opened = os.open

    def denied(path: str, flags: int) -> int:
        if path == "base.yaml":
            raise PermissionError(13, "Permission denied", path)
        return opened(path, flags)

    monkeypatch.setattr(os, "open", denied)
    lines = problems(kind=UnreadableScenarioError)
    assert lines == ["cannot be read: Permission denied  (base.yaml)"]
    monkeypatch.undo()
