"""Wrong settings and options of the command line are refused, each with the whole message."""

from __future__ import annotations

import pytest

from tests.refusals import TOP
from tests.scenarios.conftest import Refusal


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
def test_wrong_settings_are_refused(refusal: Refusal, settings: list[str], line: str) -> None:
    text = (
        "seed: 7\ncontrol: {v2v_wait_ms: 20, schedule: []}\n"
        "events: [{vehicle: 5, at_s: 1, duration_s: 1, deceleration_mps2: 1}]\n"
    )
    assert refusal(text, *settings) == line


def test_a_deeply_nested_setting_is_refused(refusal: Refusal) -> None:
    setting = ".".join("a" * 5000) + "="
    example = "such as channel.loss.p=0.3"
    place = f"--set {setting}"[:299] + "…"
    assert refusal("{}", setting) == f"not of the form key=value, {example}  ({place})"


def test_wrong_options_are_refused(refusal: Refusal) -> None:
    assert refusal("{}", "seed=3", "channel.frame_bytes=0", seed=-3, duration_s=0.01) == (
        "channel.frame_bytes: 0 is not in [1, 65535]  (--set channel.frame_bytes=0)\n"
        "seed: -3 is not in [0, 9223372036854775808)  (--seed -3)\n"
        "duration_s: 0.01 is not at least one period, period_ms (100)  (--duration-s 0.01)"
    )


def test_the_setting_that_causes_a_disagreement_is_named(refusal: Refusal) -> None:
    assert refusal("duration_s: 5\n", "period_ms=6000", "seed=2") == (
        "duration_s: 5 is not at least one period, period_ms (6000)  (--set period_ms=6000)"
    )


def test_a_setting_repairs_a_file(refusal: Refusal) -> None:
    assert refusal("seed: x\nfleet: {size: 2}\n", "fleet.size=3") == (
        "seed: 'x' is not a whole number  (s.yaml, line 1)"
    )
