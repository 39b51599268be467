"""Wrong values and keys are refused, each with the whole message."""

from __future__ import annotations

import pytest

from tests.refusals import TOP
from tests.scenarios.conftest import Refusal


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
def test_values_out_of_range_are_refused(refusal: Refusal, text: str, line: str) -> None:
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
            "speed_mps, initial_gaps_m, initial_speeds_mps, reported_gaps, groups  "
            "(s.yaml, line 2)",
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
def test_wrong_types_and_choices_are_refused(refusal: Refusal, text: str, line: str) -> None:
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
def test_unknown_and_missing_keys_are_refused(refusal: Refusal, text: str, line: str) -> None:
    assert refusal(text) == line
