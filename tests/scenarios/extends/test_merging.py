"""A scenario may extend another and have only what differs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenarios.extends.conftest import BASE, Write
from zenvoy.scenarios import (
    Control,
    Fleet,
    Gains,
    InvalidScenarioError,
    Scenario,
    Switch,
    UnknownScenarioError,
    load,
)


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


def test_a_setting_and_an_extension_repair_a_base(write: Write) -> None:
    write({"base.yaml": "seed: x\nfleet: 3\n", "s.yaml": "extends: base.yaml\nfleet: {size: 4}\n"})
    assert load("s.yaml", ["seed=3"]).scenario == Scenario(seed=3, fleet=Fleet(size=4))


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
