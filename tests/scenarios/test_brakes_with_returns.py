"""A vehicle that braked returns to its speed, if its brake says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenarios.motions import S_NS, motion, scenario_of
from zenvoy.bus import messages_pb2 as pb

BRAKES = """
duration_s: 12
road: {type: open}
fleet: {size: 3, gap_m: 500}
sensors: {error: 0}
control: {model: FM, desired_gap_m: 500, gains: {k_d: 0, k_v: 0, k_c: 0}}
events:
  - {vehicle: 1, at_s: 2.05, duration_s: 2, deceleration_mps2: 3, return_s: 4}
"""


def test_a_brake_with_a_return_ends_at_the_speed_before(tmp_path: Path) -> None:
    _, speed, events = motion(scenario_of(tmp_path, BRAKES))
    assert speed[[20, 40, 41], 0] == pytest.approx([30.0, 24.15, 24.075], abs=1e-9)
    assert speed[61, 0] == pytest.approx(24.0 + 6.0 * 2.05 / 4, abs=1e-9)
    assert speed[81:, 0] == pytest.approx([30.0] * 40, abs=1e-9)
    assert [(e.time_ns / S_NS, e.kind, e.text) for e in events] == [
        (2.05, pb.EVENT_BRAKE, "3 m/s²"),
        (4.05, pb.EVENT_BRAKE_END, ""),
        (4.05, pb.EVENT_TRACE, "return to its speed before the brake"),
        (8.05, pb.EVENT_TRACE_END, ""),
    ]


def test_a_return_gives_way_to_brakes_and_traces(tmp_path: Path) -> None:
    more = """\
  - {vehicle: 1, at_s: 5.05, duration_s: 1, deceleration_mps2: 1}
  - {vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 3, return_s: 4}
  - {type: trace, vehicle: 2, at_s: 3, points: [[0, 28], [1, 20], [2, 20]]}
"""
    _, speed, _ = motion(scenario_of(tmp_path, BRAKES + more))
    # It brakes from 25.5 m/s for a second, and then has two seconds to regain its speed.
    assert speed[[51, 61], 0] == pytest.approx([25.45, 24.5 + 0.05 * 5.5 / 2], abs=1e-9)
    assert speed[81:, 0] == pytest.approx([30.0] * 40, abs=1e-9)  # and is still in time
    assert speed[[40, 50], 1] == pytest.approx([20.0, 20.0], abs=1e-9)
    assert speed[60:, 1] == pytest.approx([30.0] * 61, abs=1e-9)


def test_a_brake_from_the_start_to_a_standstill_and_back(tmp_path: Path) -> None:
    text = BRAKES.replace("at_s: 2.05, duration_s: 2", "at_s: 0, duration_s: 5")
    _, speed, _ = motion(scenario_of(tmp_path, text.replace("mps2: 3,", "mps2: 10,")))
    assert speed[50, 0] == 0.0
    assert speed[90, 0] == pytest.approx(30.0, abs=1e-9)
