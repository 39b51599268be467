"""Scenarios that are refused, each with the whole message: a table for every kind of refusal."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from zenvoy.scenarios import (
    InvalidScenarioError,
    ScenarioError,
    UnknownScenarioError,
    UnreadableScenarioError,
    load,
)

Refusal = Callable[..., str]

TOP = (
    "extends, description, duration_s, period_ms, clock, speed, seed, stall_limit_s, on_collision, "
    "road, fleet, control, beacons, sensors, estimator, channel, events"
)


@pytest.fixture
def refusal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Refusal:
    """The message with which a file of this text is refused; the file is s.yaml."""
    monkeypatch.chdir(tmp_path)

    def refuse(
        text: str | bytes,
        *settings: str,
        kind: type[ScenarioError] = InvalidScenarioError,
        seed: int | None = None,
        duration_s: float | None = None,
    ) -> str:
        Path("s.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(kind) as caught:
            load("s.yaml", settings, seed=seed, duration_s=duration_s)
        assert type(caught.value) is kind
        assert len(caught.value.problems) == len(str(caught.value).splitlines())
        return str(caught.value)

    return refuse


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "channel:\n  loss:\n    p: 1.4\n",
            "channel.loss.p: 1.4 is not in [0, 1]  (s.yaml, line 3)",
        ),
        ("channel: {loss: {p: -0.1}}", "channel.loss.p: -0.1 is not in [0, 1]  (s.yaml, line 1)"),
        ("channel: {loss: {p: .nan}}", "channel.loss.p: nan is not in [0, 1]  (s.yaml, line 1)"),
        ("duration_s: .inf", "duration_s: inf is not in (0, 1e9]  (s.yaml, line 1)"),
        ("duration_s: -.inf", "duration_s: -inf is not in (0, 1e9]  (s.yaml, line 1)"),
        ("duration_s: 0", "duration_s: 0 is not in (0, 1e9]  (s.yaml, line 1)"),
        ("{clock: realtime, speed: 20}", "speed: 20 is not in [0.1, 10]  (s.yaml, line 1)"),
        ("speed: 2", "speed: 2 needs clock: realtime; allowed in lock-step: 1  (s.yaml, line 1)"),
        ("clock: fast", "clock: 'fast' is not one of lock-step, realtime  (s.yaml, line 1)"),
        ("duration_s: 1e10", "duration_s: 10000000000.0 is not in (0, 1e9]  (s.yaml, line 1)"),
        ("period_ms: 0.5", "period_ms: 0.5 is not in [1, 10000]  (s.yaml, line 1)"),
        ("sensors: {error: 1}", "sensors.error: 1 is not in [0, 1)  (s.yaml, line 1)"),
        ("seed: -1", "seed: -1 is not in [0, 9223372036854775808)  (s.yaml, line 1)"),
        ("fleet: {size: 1}", "fleet.size: 1 is not in [2, 10000]  (s.yaml, line 1)"),
        (
            "events: [{vehicle: 0, at_s: 1, duration_s: 1, deceleration_mps2: 1}]",
            "events.0.vehicle: 0 is not at least 1  (s.yaml, line 1)",
        ),
        (
            "channel: {bit_rate_mbps: 1e-9}",
            "channel.bit_rate_mbps: 1e-09 is not in [0.001, 1e9]  (s.yaml, line 1)",
        ),
    ],
)
def test_out_of_range(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("fleet: {size: forty}", "fleet.size: 'forty' is not a whole number  (s.yaml, line 1)"),
        (
            "fleet: {size: 40.0}",
            "fleet.size: 40.0 is not a whole number; write 40  (s.yaml, line 1)",
        ),
        ("fleet: {size: 40.5}", "fleet.size: 40.5 is not a whole number  (s.yaml, line 1)"),
        ("fleet: {size: .inf}", "fleet.size: inf is not a whole number  (s.yaml, line 1)"),
        ("fleet: {size: true}", "fleet.size: true is not a whole number  (s.yaml, line 1)"),
        ("fleet: {size: '40'}", "fleet.size: '40' is not a whole number  (s.yaml, line 1)"),
        ("fleet: {size: }", "fleet.size: null is not a whole number  (s.yaml, line 1)"),
        ("fleet: {size: [1]}", "fleet.size: a list is not a whole number  (s.yaml, line 1)"),
        ("duration_s: yes", "duration_s: 'yes' is not a number  (s.yaml, line 1)"),
        ("duration_s: false", "duration_s: false is not a number  (s.yaml, line 1)"),
        ("duration_s: {a: 1}", "duration_s: a mapping is not a number  (s.yaml, line 1)"),
        ("description: True", "description: true is not text  (s.yaml, line 1)"),
        ("description: 3", "description: 3 is not text  (s.yaml, line 1)"),
        ("events: 3", "events: 3 is not a list  (s.yaml, line 1)"),
        ("events: {a: 1}", "events: a mapping is not a list  (s.yaml, line 1)"),
        ("road: {type: circle}", "road.type: 'circle' is not one of ring, open  (s.yaml, line 1)"),
        ("road: {type: }", "road.type: null is not one of ring, open  (s.yaml, line 1)"),
        (
            "seed: 1\nfleet:\n",
            "fleet: null is not a mapping; allowed keys: size, length_m, gap_m, bumper_gap_m, "
            "speed_mps, groups  (s.yaml, line 2)",
        ),
        (
            "channel: {loss: 0.3}",
            "channel.loss: 0.3 is not a mapping; allowed keys: p, path_loss, by_distance, "
            "corrupt, gilbert_elliott, four_state  (s.yaml, line 1)",
        ),
        (
            "channel: {bit_rate_mbps: fast}",
            "channel.bit_rate_mbps: 'fast' is not a number or null  (s.yaml, line 1)",
        ),
        (
            "channel: {technology: lte}",
            "channel.technology: 'lte' is not one of ieee80211p, ieee80211px, lte-a-pro, "
            "5g-mmwave, a file such as ./mine.yaml, or a mapping  (s.yaml, line 1)",
        ),
        (
            "events:\n  - {type: swerve, vehicle: 1, at_s: 1, duration_s: 1, deceleration_mps2: 1}",
            "events.0.type: 'swerve' is not one of brake, sine, trace  (s.yaml, line 2)",
        ),
        (
            "events: [{type: , vehicle: 1, at_s: soon}]",
            "events.0.type: null is not one of brake, sine, trace  (s.yaml, line 1)",
        ),
        (
            "events: [{type: [brake]}]",
            "events.0.type: a list is not one of brake, sine, trace  (s.yaml, line 1)",
        ),
        (
            "events: [brake]",
            "events.0: 'brake' is not a mapping; its type: one of brake, sine, trace"
            "  (s.yaml, line 1)",
        ),
        (
            f"on_collision: {'x' * 100}",
            f"on_collision: '{'x' * 58}… is not one of continue, stop  (s.yaml, line 1)",
        ),
    ],
)
def test_wrong_types_and_choices(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "channel:\n\n  los: 0.3\n",
            "channel.los: unknown key; did you mean 'loss'? "
            "allowed: technology, title, band_ghz, bandwidth, range_m, bit_rate, bit_rate_mbps, "
            "delay_ms, broadcast, csma, v2v, mimo, latency, loss, medium, relay_hops, duplicate, "
            "rules, outages, frame_bytes  (s.yaml, line 3)",
        ),
        ("quux: 1", f"quux: unknown key; allowed: {TOP}  (s.yaml, line 1)"),
        ("1: 1", f"1: unknown key; allowed: {TOP}  (s.yaml, line 1)"),
        ("'<<': {seed: 3}", f"<<: unknown key; allowed: {TOP}  (s.yaml, line 1)"),
        ('"a\\nb": 1', f"a\\nb: unknown key; allowed: {TOP}  (s.yaml, line 1)"),
        (
            "events:\n- {at_s: 1, duration_s: 1, deceleration_mps2: 1}",
            "events.0.vehicle: missing; allowed: a whole number at least 1  (s.yaml, line 2)",
        ),
        (
            "control: {schedule: [{at_s: 1}]}",
            "control.schedule.0: changes nothing; allowed: model, desired_gap_m, "
            "desired_speed_mps or gains  (s.yaml, line 1)",
        ),
        (
            "control: {schedule: [{model: FM}]}",
            "control.schedule.0.at_s: missing; allowed: a number in [0, 1e9]  (s.yaml, line 1)",
        ),
    ],
)
def test_unknown_and_missing_keys(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "control:\n  v2v_wait_ms: 140\n",
            "control.v2v_wait_ms: 140 is not less than period_ms (100)  (s.yaml, line 2)",
        ),
        (
            "control: {v2v_wait_ms: 11}\nperiod_ms: 11\n",
            "control.v2v_wait_ms: 11 is not less than period_ms (11)  (s.yaml, line 1)",
        ),
        (
            "fleet: {gap_m: 5}",
            "fleet.gap_m: 5 is not greater than fleet.length_m (5)  (s.yaml, line 1)",
        ),
        (
            "fleet: {gap_m: 4.9999999}",
            "fleet.gap_m: 4.9999999 is not greater than fleet.length_m (5)  (s.yaml, line 1)",
        ),
        (
            "control: {desired_gap_m: 4.5}",
            "control.desired_gap_m: 4.5 is not greater than fleet.length_m (5)  (s.yaml, line 1)",
        ),
        (
            "duration_s: 0.0999",
            "duration_s: 0.0999 is not at least one period, period_ms (100)  (s.yaml, line 1)",
        ),
        (
            "events:\n- {vehicle: 40, at_s: 1, duration_s: 1, deceleration_mps2: 1}\n"
            "- {vehicle: 41, at_s: 1, duration_s: 1, deceleration_mps2: 1}\n",
            "events.1.vehicle: 41 is not in [1, 40], the vehicles of fleet.size (40)"
            "  (s.yaml, line 3)",
        ),
        (
            "control:\n  schedule:\n  - {at_s: 10, model: FM}\n  - {at_s: 10, model: BCM}\n",
            "control.schedule.1.at_s: 10 is not later than the switch before (10)"
            "  (s.yaml, line 4)",
        ),
        (
            "fleet: {size: 2}",
            "fleet.size: 2 is not at least 3, which PBCM needs on the ring  (s.yaml, line 1)",
        ),
        (
            "control: {model: FM, schedule: [{at_s: 10, model: BCM}]}\nfleet:\n  size: 2",
            "fleet.size: 2 is not at least 3, which BCM needs on the ring  (s.yaml, line 3)",
        ),
    ],
)
def test_values_that_disagree(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


def test_values_that_just_agree(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(
        "duration_s: 0.1\nfleet: {size: 2, gap_m: 5.001}\nroad: {type: open}\n"
        "control: {desired_gap_m: 5.1, v2v_wait_ms: 99.999,"
        " schedule: [{at_s: 0, model: FM}, {at_s: 1e-9, model: BCM}]}\n"
        "events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 1}]\n"
    )
    assert load(path).scenario.cycles == 1
    settings = ["road.type=ring", "control.model=FM", "control.schedule=[]"]
    assert load(path, settings).scenario.ring_length_m == pytest.approx(10.002)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "seed: 1\nseed: 2\n",
            "seed: given twice, first in s.yaml, line 1; allowed: once  (s.yaml, line 2)",
        ),
        (
            "fleet:\n  size: 4\n  gap_m: 9\n  size: 4\n",
            "fleet.size: given twice, first in s.yaml, line 2; allowed: once  (s.yaml, line 4)",
        ),
        ("? [a]\n: 1\n", "a key is a list or a mapping; allowed: text  (s.yaml, line 1)"),
        (
            "seed: !dice 6",
            "seed: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
            "  (s.yaml, line 1)",
        ),
        (
            "fleet: !!set {size, gap_m}",
            "fleet: the tag !!set is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
            "  (s.yaml, line 1)",
        ),
        ("seed: !!int six", "seed: 'six' is not a whole number below 1e308  (s.yaml, line 1)"),
        ("seed: !!float six", "seed: 'six' is not a number  (s.yaml, line 1)"),
        (
            "%YAML 1.1\n---\ndescription: yes",
            "description: 'yes' is not one of true, false  (s.yaml, line 3)",
        ),
        (
            f"seed: 0x1{'0' * 300}",
            f"seed: '0x1{'0' * 55}… is not a whole number below 1e308  (s.yaml, line 1)",
        ),
        (
            f"seed: {'9' * 5000}",
            f"seed: '{'9' * 58}… is not a whole number below 1e308  (s.yaml, line 1)",
        ),
        (
            'description: "\\ud800"',
            "description: '\\ud800' is not text; half a surrogate pair is not a character"
            "  (s.yaml, line 1)",
        ),
        (
            '"\\ud800": 1',
            "'\\ud800' is not text; half a surrogate pair is not a character  (s.yaml, line 1)",
        ),
        ("[1, 2]", "a list is not a mapping; the top level must be one  (s.yaml)"),
        ("hello", "text is not a mapping; the top level must be one  (s.yaml)"),
        ("", "empty; allowed: a mapping ({} for the defaults alone)  (s.yaml)"),
        ("# nothing\n", "empty; allowed: a mapping ({} for the defaults alone)  (s.yaml)"),
    ],
)
def test_yaml_that_a_scenario_may_not_use(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "seed: 1\nfleet: [1\n",
            "not valid YAML: while parsing a flow sequence, expected ',' or ']', but got "
            "'<stream end>'  (s.yaml, line 3)",
        ),
        (
            "seed: 1\n\tx: 3\n",
            "not valid YAML: while scanning for the next token, found character '\\t' that cannot "
            "start any token  (s.yaml, line 2)",
        ),
        ("seed: *s", "not valid YAML: found undefined alias 's'  (s.yaml, line 1)"),
        (
            "seed: 1\n---\nseed: 2\n",
            "not valid YAML: expected a single document in the stream, but found another document"
            "  (s.yaml, line 2)",
        ),
        (
            "seed: 1\na: \x07",
            "not valid YAML: U+0007 is not a printable character  (s.yaml, line 2)",
        ),
        (b"seed: 1\n# \xff\n", "not UTF-8: byte 0xff  (s.yaml, line 2)"),
        ("a: &a\n  b: *a", "more than the limit of 50 levels  (s.yaml, line 2)"),
        ("[" * 5000, "more than the limit of 50 levels  (s.yaml)"),
        (
            "a: &a [0,0,0,0,0,0,0,0,0,0]\n"
            + "".join(
                f"{b}: &{b} [{','.join([f'*{a}'] * 10)}]\n"
                for a, b in zip("abcde", "bcdef", strict=True)
            ),
            "more than the limit of 200000 values  (s.yaml, line 1)",
        ),
    ],
)
def test_files_that_cannot_be_read(refusal: Refusal, text: str | bytes, line: str) -> None:
    assert refusal(text, kind=UnreadableScenarioError) == line


def test_a_file_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(path: str, _flags: int) -> int:
        raise PermissionError(13, "Permission denied", path)

    path = tmp_path / "s.yaml"
    path.write_text("seed: 1\n")
    monkeypatch.setattr(os, "open", denied)
    with pytest.raises(UnreadableScenarioError) as caught:
        load(path)
    assert str(caught.value) == f"cannot be read: Permission denied  ({path})"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("paper/case15", "did you mean 'paper/case-15'? "),
        ("quikstart", "did you mean 'quickstart'? "),
        ("zzz", ""),
        ("a\0b", ""),
        ("x" * 50, ""),
    ],
)
def test_unknown_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, hint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnknownScenarioError) as caught:
        load(name)
    message = str(caught.value)
    start = f"{name!r} is neither a file nor a built-in scenario; {hint}built-in: "
    assert message.startswith(start)
    assert {"paper/case-15", "quickstart"} <= set(message.removeprefix(start).split(", "))


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (
            ["channel.loss.p=1.4"],
            "channel.loss.p: 1.4 is not in [0, 1]  (--set channel.loss.p=1.4)",
        ),
        (
            ["chanel.loss.p=1"],
            f"chanel: unknown key; did you mean 'channel'? allowed: {TOP}  (--set chanel.loss.p=1)",
        ),
        (["seed"], "not of the form key=value, such as channel.loss.p=0.3  (--set seed)"),
        (["=1"], "not of the form key=value, such as channel.loss.p=0.3  (--set =1)"),
        (["a..b=1"], "not of the form key=value, such as channel.loss.p=0.3  (--set a..b=1)"),
        (
            ["seed=["],
            "not valid YAML: while parsing a flow node, expected the node content, but found "
            "'<stream end>'  (--set seed=[)",
        ),
        (
            ["seed=!dice 6"],
            "seed: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
            "  (--set seed=!dice 6)",
        ),
        (
            ["fleet={size: 30, size: 4}"],
            "fleet.size: given twice, first in --set fleet={size: 30, size: 4}; allowed: once"
            "  (--set fleet={size: 30, size: 4})",
        ),
        (
            ["events.2.vehicle=3"],
            "events.2: no such entry; allowed: 0 to 1 (1 adds one)  (--set events.2.vehicle=3)",
        ),
        (
            ["control.schedule.first.model=FM"],
            "control.schedule.first: no such entry; allowed: 0 (0 adds one)"
            "  (--set control.schedule.first.model=FM)",
        ),
        (
            ["seed.x=3"],
            "seed.x: cannot be set; seed is 7, neither a mapping nor a list  (--set seed.x=3)",
        ),
        (
            ["period_ms=10"],
            "control.v2v_wait_ms: 20 is not less than period_ms (10)  (--set period_ms=10)",
        ),
        (
            ["fleet.size=30", "fleet.size=4"],
            "events.0.vehicle: 5 is not in [1, 4], the vehicles of fleet.size (4)"
            "  (--set fleet.size=4)",
        ),
        (["seed=a\nb"], "seed: 'a b' is not a whole number  (--set seed=a\\nb)"),
    ],
)
def test_settings(refusal: Refusal, settings: list[str], line: str) -> None:
    text = (
        "seed: 7\ncontrol: {v2v_wait_ms: 20, schedule: []}\n"
        "events: [{vehicle: 5, at_s: 1, duration_s: 1, deceleration_mps2: 1}]\n"
    )
    assert refusal(text, *settings) == line


def test_a_setting_nested_beyond_reason(refusal: Refusal) -> None:
    setting = ".".join("a" * 5000) + "="
    example = "such as channel.loss.p=0.3"
    place = f"--set {setting}"[:299] + "…"
    assert refusal("{}", setting) == f"not of the form key=value, {example}  ({place})"


def test_options(refusal: Refusal) -> None:
    assert refusal("{}", "seed=3", "channel.frame_bytes=0", seed=-3, duration_s=0.01) == (
        "channel.frame_bytes: 0 is not in [1, 65535]  (--set channel.frame_bytes=0)\n"
        "seed: -3 is not in [0, 9223372036854775808)  (--seed -3)\n"
        "duration_s: 0.01 is not at least one period, period_ms (100)  (--duration-s 0.01)"
    )


def test_the_setting_that_brings_a_disagreement_about_is_named(refusal: Refusal) -> None:
    assert refusal("duration_s: 5\n", "period_ms=6000", "seed=2") == (
        "duration_s: 5 is not at least one period, period_ms (6000)  (--set period_ms=6000)"
    )


def test_a_setting_repairs_a_file(refusal: Refusal) -> None:
    assert refusal("seed: x\nfleet: {size: 2}\n", "fleet.size=3") == (
        "seed: 'x' is not a whole number  (s.yaml, line 1)"
    )


def test_everything_that_is_wrong_is_said_at_once_in_order(refusal: Refusal) -> None:
    text = """\
duration_s: 0.05
fleet: {size: forty, gap_m: 5}
channel:
  los: 0.3
  loss:
    p: 1.4
  loss: {}
control:
  v2v_wait_ms: 140
  schedule:
    - {at_s: 10, model: X}
    - 3
    - {at_s: 10, model: FM}
    - {at_s: 5, model: FM}
seed: !dice 6
events:
  - {vehicle: 45, at_s: soon, duration_s: 3, deceleration_mps2: 3}
  - {vehicle: 1, at_s: 3, duration_s: 3, deceleration_mps2: 3, foo: 3}
sensors:
"""
    assert refusal(text, "events.9.at_s=3", "channel.frame_bytes=0").splitlines() == [
        "duration_s: 0.05 is not at least one period, period_ms (100)  (s.yaml, line 1)",
        "fleet.size: 'forty' is not a whole number  (s.yaml, line 2)",
        "fleet.gap_m: 5 is not greater than fleet.length_m (5)  (s.yaml, line 2)",
        "channel.los: unknown key; did you mean 'loss'? "
        "allowed: technology, title, band_ghz, bandwidth, range_m, bit_rate, bit_rate_mbps, "
        "delay_ms, broadcast, csma, v2v, mimo, latency, loss, medium, relay_hops, duplicate, "
        "rules, outages, frame_bytes  (s.yaml, line 4)",
        "channel.loss.p: 1.4 is not in [0, 1]  (s.yaml, line 6)",
        "channel.loss: given twice, first in s.yaml, line 5; allowed: once  (s.yaml, line 7)",
        "control.v2v_wait_ms: 140 is not less than period_ms (100)  (s.yaml, line 9)",
        "control.schedule.0.model: 'X' is not one of FM, BCM, MBCM, PBCM, CACC or null"
        "  (s.yaml, line 11)",
        "control.schedule.1: 3 is not a mapping; allowed keys: at_s, vehicles, model, parameters, "
        "desired_gap_m, desired_bumper_gap_m, desired_speed_mps, gains, ramp_s"
        "  (s.yaml, line 12)",
        "control.schedule.3.at_s: 5 is not later than the switch before (10)  (s.yaml, line 14)",
        "seed: the tag !dice is not one of !!map, !!seq, !!null, !!bool, !!int, !!float, !!str"
        "  (s.yaml, line 15)",
        "events.0.at_s: 'soon' is not a number  (s.yaml, line 17)",
        "events.1.foo: unknown key; allowed: type, vehicle, at_s, duration_s, deceleration_mps2, "
        "return_s  (s.yaml, line 18)",
        "sensors: null is not a mapping; allowed keys: error, distribution, position_std_m"
        "  (s.yaml, line 19)",
        "events.9: no such entry; allowed: 0 to 2 (2 adds one)  (--set events.9.at_s=3)",
        "channel.frame_bytes: 0 is not in [1, 65535]  (--set channel.frame_bytes=0)",
    ]


def test_a_refused_value_does_not_hide_what_disagrees_beside_it(refusal: Refusal) -> None:
    text = "events: [{vehicle: 45, at_s: soon, duration_s: 3, deceleration_mps2: 3}]"
    assert refusal(text).splitlines() == [
        "events.0.at_s: 'soon' is not a number  (s.yaml, line 1)",
        "events.0.vehicle: 45 is not in [1, 40], the vehicles of fleet.size (40)  (s.yaml, line 1)",
    ]
