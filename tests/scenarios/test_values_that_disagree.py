"""Values that disagree are refused, and all mistakes are reported at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenarios.conftest import Refusal
from zenvoy.laws import builtin
from zenvoy.scenarios import (
    load,
)


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
        (
            "control:\n  neighbour_state: position\n  schedule: [{at_s: 10, model: SPBCM}]\n",
            "control.neighbour_state: position does not go with SPBCM, which shares radar readings;"
            " allowed: radar  (s.yaml, line 2)",
        ),
    ],
)
def test_values_that_disagree_are_refused(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line


def test_values_that_just_agree_are_accepted(tmp_path: Path) -> None:
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


def test_all_mistakes_are_reported_at_once_in_order(refusal: Refusal) -> None:
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
        f"control.schedule.0.model: 'X' is not one of {', '.join(builtin())}, null, "
        "or file:NAME such as fvdm:FVDM  (s.yaml, line 11)",
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


def test_a_refused_value_does_not_hide_disagreements_beside_it(refusal: Refusal) -> None:
    text = "events: [{vehicle: 45, at_s: soon, duration_s: 3, deceleration_mps2: 3}]"
    assert refusal(text).splitlines() == [
        "events.0.at_s: 'soon' is not a number  (s.yaml, line 1)",
        "events.0.vehicle: 45 is not in [1, 40], the vehicles of fleet.size (40)  (s.yaml, line 1)",
    ]
