"""A scenario may extend another and have only what differs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from tests.conftest import read_log, zenvoy
from zenvoy.scenarios import (
    Brake,
    Control,
    Fleet,
    Gains,
    InvalidScenarioError,
    Scenario,
    ScenarioError,
    Switch,
    UnknownScenarioError,
    UnreadableScenarioError,
    builtin,
    effective_yaml,
    load,
)

Write = Callable[..., None]


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    """Return a function that writes files by path, below the current folder."""
    monkeypatch.chdir(tmp_path)

    def write_them(texts: Mapping[str, str]) -> None:
        for path, text in texts.items():
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            Path(path).write_text(text)

    return write_them


BASE = """\
description: the base
seed: 7
fleet: {size: 9, gap_m: 50}
control:
  model: FM
  schedule: [{at_s: 10, model: BCM}]
  gains: {k_d: 0.2, k_v: 0.6}
events: [{vehicle: 9, at_s: 10, duration_s: 2, deceleration_mps2: 3}]
"""


def test_mappings_merge_and_other_values_replace(write: Write) -> None:
    text = """\
extends: base.yaml
fleet: {gap_m: 60}
control:
  gains: {k_v: 0.7, k_c: 0.1}
  schedule: [{at_s: 20, model: PBCM}]
events: []
"""
    write({"base.yaml": BASE, "s.yaml": text})
    loaded = load("s.yaml")
    assert (loaded.name, loaded.text) == ("s", text)
    assert loaded.scenario == Scenario(
        description="the base",
        seed=7,
        fleet=Fleet(size=9, gap_m=60),
        control=Control(
            model="FM",
            schedule=(Switch(at_s=20, model="PBCM"),),
            gains=Gains(k_d=0.2, k_v=0.7, k_c=0.1),
        ),
    )


def test_a_scenario_may_consist_of_extends_alone(write: Write) -> None:
    write({"base.yaml": BASE, "s.yaml": "extends: base.yaml\n"})
    assert load("s.yaml").scenario == load("base.yaml").scenario


def test_each_path_in_a_chain_is_relative_to_its_own_file(write: Write) -> None:
    write(
        {
            "a/b/s.yaml": "extends: ../middle.yaml\nseed: 1\n",
            "a/middle.yaml": "extends: c/base.yaml\nseed: 2\nduration_s: 2\n",
            "a/c/base.yaml": "extends: quickstart\nseed: 3\nduration_s: 3\nperiod_ms: 50\n",
            "middle.yaml": "not: this\n",
        }
    )
    quickstart = load("quickstart").scenario
    changes = {"seed": 1, "duration_s": 2.0, "period_ms": 50.0}
    assert load("a/b/s.yaml").scenario == quickstart.model_copy(update=changes)
    assert load(Path.cwd() / "a/b/s.yaml").scenario == load("a/b/s.yaml").scenario


def test_a_file_beside_comes_before_a_built_in_of_that_name(write: Write) -> None:
    write({"sub/s.yaml": "extends: quickstart\n", "quickstart": "seed: 5\n"})
    assert load("sub/s.yaml").scenario == load(Path("sub/s.yaml").absolute()).scenario
    assert load("sub/s.yaml").scenario.seed == 1
    write({"sub/quickstart": "seed: 6\n"})
    assert load("sub/s.yaml").scenario.seed == 6


@pytest.fixture
def packaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Write) -> Write:
    """Return a function that writes built-in scenarios, in place of those of the package."""
    monkeypatch.setattr("zenvoy.scenarios.reading.library.files", lambda _: tmp_path / "package")
    return lambda texts: write({f"package/{path}": text for path, text in texts.items()})


def test_built_in_scenarios_extend_built_in_ones_by_name(packaged: Write, write: Write) -> None:
    packaged(
        {
            "paper/base.yaml": "seed: 7\ndescription: base\n",
            "paper/a.yaml": "extends: paper/base\ndescription: a\n",
            "paper/b.yaml": "extends: ../s.yaml\n",
            "paper/c.yaml": "extends: base\n",
        }
    )
    write({"s.yaml": "seed: 8\n", "paper/base": "seed: 9\n"})
    assert load("paper/a").scenario == Scenario(seed=7, description="a")
    for name, reference in (("paper/b", "../s.yaml"), ("paper/c", "base")):
        with pytest.raises(UnknownScenarioError) as caught:
            load(name)
        assert str(caught.value).startswith(f"extends: {reference!r} is not a built-in scenario; ")
        assert str(caught.value).endswith(f"(built-in {name}, line 1)")


def test_a_built_in_scenario_reads_traces_in_the_package(packaged: Write, write: Write) -> None:
    event = "events: [{type: trace, vehicle: 1, at_s: 0, file: a/x.csv}]\n"
    packaged({"lead/t.yaml": event, "lead/a/x.csv": "time_s,speed_mps\n0,1\n1,2\n"})
    write({"s.yaml": "extends: lead/t\nseed: 3\n"})
    assert load("lead/t").scenario.events == load("s.yaml").scenario.events
    packaged({"lead/a/x.csv": "time_s,speed_mps\n0,1\n1,fast\n"})
    with pytest.raises(InvalidScenarioError) as caught:
        load("s.yaml")
    assert str(caught.value) == (
        "events.0.file: speed_mps: 'fast' is not a number  (built-in lead/a/x.csv, line 3)"
    )


# Refusals -----------------------------------------------------------------------------------


def refusal(
    *settings: str, kind: type[ScenarioError] = InvalidScenarioError, name: str = "s.yaml"
) -> list[str]:
    with pytest.raises(kind) as caught:
        load(name, settings)
    assert type(caught.value) is kind
    return str(caught.value).splitlines()


def test_errors_point_to_the_file_that_has_the_value(write: Write) -> None:
    write(
        {
            "base.yaml": "seed: x\n\nfleet:\n  size: 1\n  colour: red\nchannel: {loss: {p: 0}}\n",
            "middle.yaml": "extends: base.yaml\nduration_s: -1\nfleet: {length_m: 0}\n",
            "s.yaml": "extends: middle.yaml\nfleet:\n  gap_m: no\nchannel: {loss: {p: 2}}\n",
        }
    )
    assert refusal("period_ms=0") == [
        "seed: 'x' is not a whole number  (base.yaml, line 1)",
        "fleet.size: 1 is not in [2, 10000]  (base.yaml, line 4)",
        "fleet.colour: unknown key; allowed: size, length_m, gap_m, bumper_gap_m, speed_mps, "
        "groups"
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
    assert refusal() == [f"{line}  (s.yaml, line 3)"]
    write({"s.yaml": "extends: base.yaml\nseed: 1\n"})
    assert refusal("fleet.size=8") == [f"{line}  (--set fleet.size=8)"]
    write({"base.yaml": BASE.replace("size: 9", "size: 8")})
    assert refusal() == [f"{line}  (base.yaml, line 8)"]
    assert load("s.yaml", ["fleet.size=9"]).scenario.fleet.size == 9


def test_errors_of_reading_a_base_are_reported_even_if_the_value_is_replaced(write: Write) -> None:
    base = "seed: 1\nseed: 2\nfleet: !dice 6\n"
    write({"base.yaml": base, "s.yaml": "extends: base.yaml\nseed: 3\nfleet: {size: 4}\n"})
    assert refusal() == [
        "seed: given twice, first in base.yaml, line 1; allowed: once  (base.yaml, line 2)",
        "fleet: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
        "  (base.yaml, line 3)",
    ]


def test_a_setting_and_an_extension_repair_a_base(write: Write) -> None:
    write({"base.yaml": "seed: x\nfleet: 3\n", "s.yaml": "extends: base.yaml\nfleet: {size: 4}\n"})
    assert load("s.yaml", ["seed=3"]).scenario == Scenario(seed=3, fleet=Fleet(size=4))


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
    assert refusal(kind=kind) == [line]


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
    lines = refusal(kind=UnreadableScenarioError)
    assert lines == ["cannot be read: Permission denied  (base.yaml)"]
    monkeypatch.undo()


@pytest.mark.parametrize(
    ("value", "what"),
    [
        ("3", "3 is not"),
        ("", "null is not"),
        ("[a, b]", "a list is not"),
        ("{a: b}", "a mapping is not"),
        ('""', "'' is not"),
    ],
)
def test_extends_must_name_one_scenario(write: Write, value: str, what: str) -> None:
    write({"s.yaml": f"seed: 1\nextends: {value}\n"})
    line = f"extends: {what} the name of a scenario: a file or a built-in one  (s.yaml, line 2)"
    assert refusal() == [line]


def test_extends_with_a_tag_is_refused(write: Write) -> None:
    write({"s.yaml": "extends: !dice 3\n"})
    assert refusal() == [
        "extends: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
        "  (s.yaml, line 1)"
    ]


@pytest.mark.parametrize(("name", "hint"), [("paper/base", True), ("zzz", False), ("a\\0b", False)])
def test_a_missing_base_is_refused(packaged: Write, write: Write, name: str, hint: bool) -> None:
    packaged({"paper/bose.yaml": "{}", "q.yaml": "{}"})
    write({"s.yaml": f'seed: x\nextends: "{name}"\n'})
    shown = name.replace("\\0", "\\x00")
    near = "did you mean 'paper/bose'? " if hint else ""
    assert refusal(kind=UnknownScenarioError) == [
        f"extends: '{shown}' is neither a file nor a built-in scenario; {near}built-in: "
        "paper/bose, q  (s.yaml, line 2)"
    ]


def test_circles_of_any_length_are_refused(write: Write) -> None:
    write({"s.yaml": "seed: 1\nextends: s.yaml\n"})
    allowed = "allowed: a scenario outside of it"
    assert refusal() == [
        f"extends: 's.yaml' closes a cycle: s.yaml → s.yaml; {allowed}  (s.yaml, line 2)"
    ]
    write(
        {
            "s.yaml": "extends: sub/a.yaml\n",
            "sub/a.yaml": "extends: b.yaml\n",
            "sub/b.yaml": "seed: 1\nextends: ../sub/a.yaml\n",
        }
    )
    assert refusal() == [
        "extends: '../sub/a.yaml' closes a cycle: sub/a.yaml → sub/b.yaml → sub/../sub/a.yaml; "
        f"{allowed}  (sub/b.yaml, line 2)"
    ]


def test_circles_in_the_package_are_refused(packaged: Write) -> None:
    packaged({"a.yaml": "extends: b\n", "b.yaml": "extends: a\n"})
    assert refusal(name="a") == [
        "extends: 'a' closes a cycle: built-in a → built-in b → built-in a; "
        "allowed: a scenario outside of it  (built-in b, line 1)"
    ]


def test_a_misspelt_extends_is_recognised(write: Write) -> None:
    write({"s.yaml": "extend: quickstart\n"})
    (line,) = refusal()
    assert line.startswith("extend: unknown key; did you mean 'extends'? allowed: extends, desc")
    write({"s.yaml": "fleet: {extends: quickstart}\n"})
    assert refusal() == [
        "fleet.extends: unknown key; allowed: size, length_m, gap_m, bumper_gap_m, speed_mps, "
        "groups"
        "  (s.yaml, line 1)"
    ]


@pytest.mark.parametrize("key", ["extends", "extends.x"])
def test_extends_is_not_for_the_command_line(write: Write, key: str) -> None:
    write({"s.yaml": "seed: 1\n"})
    line = f"{key}: cannot be set; allowed in a file only  (--set {key}=quickstart)"
    assert refusal(f"{key}=quickstart") == [line]


# Output -------------------------------------------------------------------------------------


def test_the_command_shows_the_whole_scenario_and_the_log_keeps_both(tmp_path: Path) -> None:
    text = "extends: base.yaml\nduration_s: 1\nevents: []\n"
    (tmp_path / "base.yaml").write_text(BASE)
    (tmp_path / "s.yaml").write_text(text)
    shown = zenvoy(tmp_path, "show", "s.yaml", "--set", "seed=8")
    assert (shown.code, shown.err) == (0, "")
    assert "extends" not in shown.out
    (tmp_path / "whole.yaml").write_text(shown.out)
    whole = load(tmp_path / "whole.yaml").scenario
    assert whole == load(tmp_path / "s.yaml", ["seed=8"]).scenario
    assert (whole.seed, whole.duration_s, whole.fleet.size) == (8, 1.0, 9)

    ran = zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--seed", "8", "--out", "out")
    assert ran.code == 0, ran
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.attachments["scenario.yaml"].decode() == text
    effective = log.attachments["effective.json"].decode()
    assert Scenario.model_validate_json(effective) == whole
    assert "extends" not in json.loads(effective)


def test_the_command_refuses_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("extends: nowhere\n")
    refused = zenvoy(tmp_path, "check", "s.yaml")
    assert refused.code == 2
    assert refused.err.startswith("extends: 'nowhere' is neither a file nor a built-in scenario; ")
    assert refused.err.count("\n") == 1


# A whole, split -----------------------------------------------------------------------------

Values = dict[str, Any]

WHOLES = [load(name).scenario for name, _ in builtin()[:3]] + [
    Scenario(
        fleet=Fleet(size=5),
        control=Control(model="FM", schedule=(Switch(at_s=3, model="BCM"),), gains=Gains(k_d=0.3)),
        events=(Brake(vehicle=5, at_s=1, duration_s=1, deceleration_mps2=1),),
    )
]
junk = st.none() | st.integers(-3, 3) | st.text(max_size=3) | st.lists(st.integers(), max_size=2)


@st.composite
def split(draw: st.DrawFn, whole: Values) -> tuple[Values, Values]:
    """Split a scenario into a base and its extension. Some values are in both."""
    base: Values = {}
    extension: Values = {}
    for key, value in whole.items():
        where = draw(st.sampled_from(["base", "extension", "both"]))
        if where != "both":
            (base if where == "base" else extension)[key] = value
        elif isinstance(value, dict):
            base[key], extension[key] = draw(split(value))
        else:
            base[key], extension[key] = draw(junk), value
    return base, extension


def _yaml(values: Values) -> str:
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False  # within braces, the reader of YAML refuses its own `?x`
    stream = StringIO()
    yaml.dump(values, stream)
    return stream.getvalue()


@settings(deadline=None)
@given(st.sampled_from(WHOLES), st.data())
def test_a_scenario_split_at_random_loads_equal_to_the_whole(
    folder: Path, whole: Scenario, data: st.DataObject
) -> None:
    base, extension = data.draw(split(whole.model_dump(mode="json")))
    root, middle = data.draw(split(base))
    texts = {
        "root": _yaml(root),
        "middle": _yaml({"extends": "root.yaml", **middle}),
        "s": _yaml({**extension, "extends": "middle.yaml"}),
    }
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    assert load(folder / "s.yaml").scenario == whole
    assert load(folder / "s.yaml", ["seed=5"]).scenario == whole.model_copy(update={"seed": 5})
    (folder / "again.yaml").write_text(effective_yaml(load(folder / "s.yaml").scenario))
    assert load(folder / "again.yaml").scenario == whole
