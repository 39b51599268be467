"""Valid scenarios are read from files, names and overrides, and written as YAML and JSON."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from tests.scenarios.conftest import Write
from zenvoy import scenarios
from zenvoy.scenarios import (
    Brake,
    Channel,
    Control,
    Fleet,
    Gains,
    Loss,
    Road,
    Scenario,
    ScenarioError,
    Switch,
    load,
)


def test_a_file_has_what_differs_from_the_defaults(write: Write) -> None:
    text = "fleet: {size: 7}\r\nchannel:\r\n  loss: {p: 0.25}\r\n"
    loaded = load(write(text))
    assert loaded.name == "s"
    assert loaded.text == text
    assert loaded.scenario == Scenario(fleet=Fleet(size=7), channel=Channel(loss=Loss(p=0.25)))


def test_an_empty_mapping_gives_the_defaults(write: Write) -> None:
    assert load(write("{}")).scenario == Scenario()


@pytest.mark.parametrize("as_given", [str, Path])
def test_a_path_may_be_text_or_a_path(write: Write, as_given: Callable[[Path], str | Path]) -> None:
    path = write("seed: 3\n")
    assert load(as_given(path)).scenario.seed == 3


def test_lists_become_tuples_and_integers_become_floats(write: Write) -> None:
    text = """
    duration_s: 60
    control: {model: FM, schedule: [{at_s: 10, model: BCM}, {at_s: 20.5, model: PBCM}]}
    events:
      - {vehicle: 5, at_s: 10, duration_s: 2, deceleration_mps2: 3}
    """
    scenario = load(write(text)).scenario
    assert scenario.control.schedule == (
        Switch(at_s=10.0, model="BCM"),
        Switch(at_s=20.5, model="PBCM"),
    )
    assert scenario.events == (Brake(vehicle=5, at_s=10, duration_s=2, deceleration_mps2=3),)
    assert type(scenario.duration_s) is float


def test_numbers_and_texts_follow_yaml_1_2(write: Write) -> None:
    text = "description: no\nseed: 012\nduration_s: 1e3\nfleet: {size: 0x10, gap_m: 0o50}\n"
    scenario = load(write(text)).scenario
    assert scenario.description == "no"
    assert scenario.seed == 12
    assert scenario.duration_s == 1000.0
    assert scenario.fleet == Fleet(size=16, gap_m=40.0)


def test_a_date_is_text(write: Write) -> None:
    assert load(write("description: 2024-05-01\n")).scenario.description == "2024-05-01"


def test_an_override_of_one_alias_leaves_the_other(write: Write) -> None:
    text = """
    events:
      - &brake {vehicle: 5, at_s: 10, duration_s: 2, deceleration_mps2: 3}
      - *brake
    """
    events = load(write(text), ["events.1.vehicle=6"]).scenario.events
    assert [event.vehicle for event in events] == [5, 6]
    assert {event.at_s for event in events} == {10.0}


def test_an_anchor_may_be_used_again(write: Write) -> None:
    scenario = load(write("seed: &n 1\nfleet: {size: &n 9}\nchannel: {frame_bytes: *n}\n")).scenario
    assert scenario.channel.frame_bytes == 9


def test_a_byte_order_mark_does_no_harm(write: Write) -> None:
    assert load(write("\ufeffseed: 3\n")).scenario.seed == 3


def test_a_file_comes_before_a_built_in_of_that_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert load("quickstart").scenario.seed == 1
    Path("quickstart").write_text("seed: 77\n")
    assert load("quickstart").scenario.seed == 77


def test_a_folder_does_not_hide_a_built_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("quickstart").mkdir()
    assert load("quickstart").name == "quickstart"


@pytest.mark.parametrize(
    ("setting", "key", "value"),
    [
        ("channel.loss.p=0.3", "channel.loss.p", 0.3),
        ("control.schedule.0.model=FM", "control.schedule.0.model", "FM"),
        ("events=[]", "events", ()),
        ("description=a=b", "description", "a=b"),
        (" fleet.size = 12 ", "fleet.size", 12),
        ("channel.bit_rate_mbps=", "channel.bit_rate_mbps", None),
        ("events.1={vehicle: 9, at_s: 1, duration_s: 1, deceleration_mps2: 1}", "events.1.at_s", 1),
    ],
)
def test_a_setting_replaces_one_value_and_no_other(setting: str, key: str, value: object) -> None:
    def flat(node: object, path: str = "") -> dict[str, object]:
        entries = node.items() if isinstance(node, dict) else enumerate(node)  # type: ignore[arg-type]
        found: dict[str, object] = {}
        for step, child in entries:
            here = f"{path}.{step}".lstrip(".")
            deeper = isinstance(child, dict | tuple) and child
            found |= flat(child, here) if deeper else {here: child}
        return found

    before = flat(load("paper/case-15").scenario.model_dump())
    after = flat(load("paper/case-15", [setting]).scenario.model_dump())
    assert after[key] == value
    entry = key.rpartition(".")[0] if key.startswith("events.") else key
    assert {k: v for k, v in before.items() if not k.startswith(entry)} == {
        k: v for k, v in after.items() if not k.startswith(entry)
    }


def test_the_last_setting_wins_and_options_win_over_settings(write: Write) -> None:
    path = write("seed: 1\n")
    assert load(path, ["seed=2", "seed=3"]).scenario.seed == 3
    scenario = load(path, ["seed=2", "duration_s=7"], seed=0, duration_s=9.5).scenario
    assert (scenario.seed, scenario.duration_s) == (0, 9.5)


def test_a_setting_may_build_a_section_that_the_file_lacks(write: Write) -> None:
    settings = ["control.gains.k_c=0.2", "control.schedule.0.at_s=5", "control.schedule.0.model=FM"]
    control = load(write("{}"), settings).scenario.control
    schedule = (Switch(at_s=5, model="FM"),)
    assert control == Control(gains=Gains(k_c=0.2), schedule=schedule, v2v_wait_ms=11.0)


def test_overrides_are_not_part_of_the_text(write: Write) -> None:
    assert load(write("seed: 1\n"), ["seed=2"]).text == "seed: 1\n"


def test_events_and_switches_may_lie_after_the_end() -> None:
    assert load("paper/case-15", duration_s=1).scenario.cycles == 10


def test_periods_are_whole_nanoseconds() -> None:
    scenario = Scenario(duration_s=1.05, period_ms=100)
    assert (scenario.period_ns, scenario.cycles) == (100_000_000, 10)
    assert (scenario.v2v_wait_ns, scenario.system_delay_ns) == (11_000_000, 89_000_000)
    assert Scenario(road=Road(type="open")).ring_length_m is None


def test_a_scenario_built_in_python_is_checked_across_sections() -> None:
    with pytest.raises(ValidationError) as refusal:
        Scenario(duration_s=0.05, control=Control(v2v_wait_ms=100))
    assert (
        "duration_s: 0.05 is not at least one period, period_ms (100)\n"
        "control.v2v_wait_ms: 100 is not less than period_ms (100)"
    ) in str(refusal.value)


def test_a_scenario_is_immutable() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Scenario().seed = 2  # type: ignore[misc]


def test_errors_can_be_pickled() -> None:
    with pytest.raises(ScenarioError) as refusal:
        load("quickstart", ["seed=-1"])
    copy = pickle.loads(pickle.dumps(refusal.value))
    assert str(copy) == str(refusal.value)
    assert copy.problems == refusal.value.problems


def test_exported_names_exist() -> None:
    assert all(hasattr(scenarios, name) for name in scenarios.__all__)
