"""A technology is a YAML file, and a scenario may replace any of its values."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.logs import write_log
from zenvoy.analysis import load as load_log
from zenvoy.bus import InProcessBus
from zenvoy.bus.log_format import Fingerprint
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import (
    Channel,
    InvalidScenarioError,
    Scenario,
    ScenarioError,
    Technology,
    effective_json,
    effective_yaml,
    load,
    technologies,
)
from zenvoy.scenarios.reading.library import inside
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.world.lock_step import LockStepWorld

MINE = "range_m: 200\nbit_rate_mbps: 12\ndelay_ms: [5, 15]\nbroadcast: true\n"


def fingerprint(scenario: Scenario) -> str:
    found = Fingerprint()
    vehicles = range(1, scenario.fleet.size + 1)
    agents = [LockStepVehicle(scenario, vehicle) for vehicle in vehicles]
    bus = InProcessBus(
        [LockStepWorld(scenario), LockStepChannel(scenario), *agents],
        lambda topic, time_ns, payload: found.add(str(topic.logged_as), time_ns, payload),
    )
    bus.run()
    return found.hexdigest()


def refusal(path: Path, *settings: str) -> list[str]:
    with pytest.raises(ScenarioError) as refused:
        load(path, settings)
    return str(refused.value).replace(f"{path.parent}/", "").splitlines()


def test_a_file_is_found_beside_the_scenario(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "mine.yaml").write_text(MINE)
    (tmp_path / "a" / "s.yaml").write_text("channel: {technology: ./mine.yaml}")
    (tmp_path / "t.yaml").write_text("extends: a/s.yaml\nchannel: {range_m: 300}")
    scenario = load(tmp_path / "t.yaml").scenario
    assert scenario.channel.technology == Technology(
        name="mine", range_m=200.0, bit_rate_mbps=12.0, delay_ms=(5.0, 15.0), broadcast=True
    )
    assert (scenario.channel.radio.range_m, scenario.channel.radio.delay_ms) == (300.0, (5.0, 15.0))
    assert scenario.control.v2v_wait_ms == 16.0  # the longest delay and 0.2 ms for a frame
    monkeypatch.chdir(tmp_path / "a")
    assert load("quickstart", ["channel.technology=mine.yaml"]).scenario.channel.technology == (
        scenario.channel.technology
    )


@pytest.mark.parametrize("name", list(technologies()))
def test_a_file_with_equal_values_gives_the_fingerprint_of_the_built_in_technology(
    tmp_path: Path, name: str
) -> None:
    text = inside(Path("radios", f"{name}.yaml")).read_text(encoding="utf-8")
    (tmp_path / "copy.yaml").write_text(text, encoding="utf-8")
    settings = ["fleet.size=7", f"channel.technology={tmp_path}/copy.yaml"]
    copy = load("quickstart", settings, duration_s=2).scenario
    settings[1] = f"channel.technology={name}"
    builtin = load("quickstart", settings, duration_s=2).scenario
    assert copy.channel.technology.name == "copy"
    assert fingerprint(copy) == fingerprint(builtin)


def test_a_run_is_repeated_without_the_file(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(MINE)
    (tmp_path / "s.yaml").write_text(
        "duration_s: 2\nfleet: {size: 5}\nchannel: {technology: ./mine.yaml, broadcast: false}"
    )
    scenario = load(tmp_path / "s.yaml").scenario
    log = load_log(write_log(tmp_path / "run.mcap", effective_yaml(scenario)))
    (tmp_path / "mine.yaml").unlink()
    assert log.scenario == Scenario.model_validate_json(effective_json(scenario)) == scenario
    assert fingerprint(log.scenario) == fingerprint(scenario)
    assert json.loads(effective_json(scenario))["channel"]["technology"]["delay_ms"] == [5.0, 15.0]


def test_an_older_log_has_only_the_name_of_its_technology() -> None:
    text = '{"channel": {"technology": "lte-a-pro", "bit_rate_mbps": null}}'
    assert Scenario.model_validate_json(text).channel.radio == technologies()["lte-a-pro"]


def test_a_scenario_may_replace_every_value_but_the_name() -> None:
    assert set(Technology.model_fields) - set(Channel.model_fields) == {"name"}
    other = {
        "title": "T",
        "band_ghz": (1.0, 2.0),
        "bandwidth": "b",
        "range_m": 1.0,
        "bit_rate": "r",
        "bit_rate_mbps": 2.0,
        "delay_ms": (3.0, 4.0),
        "broadcast": False,
        "csma": False,
        "v2v": False,
        "mimo": False,
    }
    radio = Channel.model_validate(other).radio
    assert radio == Technology.model_validate({"name": "ieee80211p", **other})


def test_replaced_values_act_like_those_of_a_technology(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(MINE)
    mine = load("quickstart", [f"channel.technology={tmp_path}/mine.yaml"], duration_s=2).scenario
    values = ["range_m=200", "bit_rate_mbps=12", "delay_ms=[5, 15]", "title=null"]
    replaced = load("quickstart", [f"channel.{value}" for value in values], duration_s=2).scenario
    assert (
        fingerprint(replaced)
        == fingerprint(mine)
        != fingerprint(load("quickstart", duration_s=2).scenario)
    )


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            MINE.replace("200", "-1"),
            "channel.technology.range_m: -1 is not in (0, 1e9]  (mine.yaml, line 1)",
        ),
        (
            MINE + "broadcst: true\n",
            "channel.technology.broadcst: unknown key; did you mean 'broadcast'? allowed: name, "
            "title, band_ghz, bandwidth, range_m, bit_rate, bit_rate_mbps, delay_ms, broadcast, "
            "csma, v2v, mimo  (mine.yaml, line 5)",
        ),
        (
            MINE.replace("delay_ms: [5, 15]\n", ""),
            "channel.technology.delay_ms: missing; allowed: a number in [0, 1e9], or a list of "
            "two such numbers in ascending order  (mine.yaml)",
        ),
        (
            MINE.replace("[5, 15]", "[15, 5]"),
            "channel.technology.delay_ms: [15, 5] is not a number in [0, 1e9], or a list of two "
            "such numbers in ascending order  (mine.yaml, line 3)",
        ),
        (
            MINE + "range_m: 3\n",
            "channel.technology.range_m: given twice, first in mine.yaml, line 1; allowed: once"
            "  (mine.yaml, line 5)",
        ),
        (
            "root:x:0:0\n",
            "channel.technology: not a technology, which is a mapping with keys of name, title, "
            "band_ghz, bandwidth, range_m, bit_rate, bit_rate_mbps, delay_ms, broadcast, csma, "
            "v2v, mimo  (mine.yaml)",
        ),
    ],
)
def test_mistakes_in_a_file_are_reported_with_their_line(
    tmp_path: Path, text: str, line: str
) -> None:
    (tmp_path / "mine.yaml").write_text(text)
    (tmp_path / "s.yaml").write_text("channel: {technology: mine.yaml}")
    assert refusal(tmp_path / "s.yaml") == [line]


def test_only_regular_files_of_a_bounded_size_are_read(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text("channel:\n  technology: ./mine.yaml\n")
    message = "channel.technology: './mine.yaml' cannot be read: {}  (s.yaml, line 2)"
    assert refusal(path) == [message.format("No such file or directory")]
    (tmp_path / "mine.yaml").mkdir()
    assert refusal(path) == [message.format("a folder, not a file")]
    (tmp_path / "mine.yaml").rmdir()
    with (tmp_path / "mine.yaml").open("wb") as file:
        file.truncate(2**24 + 1)
    assert refusal(path) == [message.format("larger than the limit of 16 MiB")]


def test_the_text_of_any_other_file_is_in_no_message(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text("channel: {technology: ./secret.yaml}")
    for secret in ("password: hunter2\n", 'a: "hunter2\n', "hunter2", "- hunter2: 1\n  hunter2: 1"):
        (tmp_path / "secret.yaml").write_text(secret)
        with pytest.raises(InvalidScenarioError) as refused:
            load(tmp_path / "s.yaml")
        assert "hunter2" not in str(refused.value)
        assert "channel.technology: " in str(refused.value)


def test_a_technology_may_use_carrier_sense(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(MINE)
    path = tmp_path / "s.yaml"
    path.write_text("channel: {technology: mine.yaml, medium: {access: csma}}")
    assert refusal(path) == [
        "channel.medium.access: csma is not possible with mine; allowed: none, or csma with "
        "ieee80211p, ieee80211px, or with a technology that has csma: true  (s.yaml, line 1)"
    ]
    (tmp_path / "mine.yaml").write_text(MINE + "csma: true\n")
    assert load(path).scenario.channel.medium.access == "csma"
    assert load(path, ["channel.csma=true"]).scenario.channel.radio.csma
    assert refusal(path, "channel.csma=false")[0].startswith("channel.medium.access: csma is not")


def test_the_note_on_range_names_the_key_that_sets_it(tmp_path: Path) -> None:
    (note,) = load("quickstart", ["channel.range_m=20"]).notes
    assert str(note).startswith("channel.range_m: a range of 20 m is less than fleet.gap_m")


def test_a_delay_that_no_latency_uses_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text("channel:\n  delay_ms: 5\n  latency: {distribution: fixed, mean_ms: 3}\n")
    assert refusal(path) == [
        "channel.delay_ms: is given, but channel.latency.distribution is fixed; allowed: null"
        "  (s.yaml, line 2)"
    ]
    path.write_text(path.read_text() + "  rules: [{source: 1, latency: {}}]\n")
    assert load(path).scenario.channel.radio.delay_ms == (5.0, 5.0)
