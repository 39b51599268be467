"""GSBL: values by hand, its gap at every speed, and its linear response in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Observation, Relative, Setpoint
from zenvoy.laws.library.gsbl import Parameters, towed

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=25.0)
LENGTH_M = 4.0


def acceleration(
    gap: float, relative: float, speed: float, leader: float, own_a: float, own: Parameters
) -> float:
    seen = Observation(
        speed,
        SETPOINT,
        Relative(gap + LENGTH_M, relative),
        leader=Motion(leader, float("nan")),
        acceleration=own_a,
        length_m=LENGTH_M,
    )
    return float(towed(seen, own))


@pytest.mark.parametrize(
    ("gap", "relative", "speed", "leader", "own_a", "own", "a"),
    [
        (6.0, 0.0, 20.0, 20.0, 0.0, Parameters(), 12.0),
        (5.0, 1.0, 20.0, 20.0, 0.0, Parameters(), 0.6),
        (5.0, 0.0, 20.0, 19.5, 0.0, Parameters(), -24.0),
        (5.0, 0.0, 20.0, 20.0, 1.0, Parameters(), -2.4),
        (10.0, -1.0, 21.0, 20.0, 0.5, Parameters(1.0, 0.5, 2.0, 3.0, 8.0), -0.5 - 0.5 - 2.0),
    ],
)
def test_acceleration_by_hand(
    gap: float,
    relative: float,
    speed: float,
    leader: float,
    own_a: float,
    own: Parameters,
    a: float,
) -> None:
    found = acceleration(gap, relative, speed, leader, own_a, own)
    assert found == pytest.approx(a, abs=1e-12)


@given(st.floats(0.0, 50.0), st.floats(0.0, 30.0), st.floats(0.0, 10.0))
def test_the_gap_does_not_depend_on_the_speed(v: float, spacing_m: float, h: float) -> None:
    own = Parameters(headway_s=h, spacing_m=spacing_m)
    assert acceleration(spacing_m, 0.0, v, v, 0.0, own) == pytest.approx(0.0, abs=1e-9)


def test_a_follower_of_the_leader_responds_as_its_transfer_says(tmp_path: Path) -> None:
    """v / v_L of (τ s² + (1 + k_a) s + k_v + k_p (h + 1 / s)) v = (k_v + k_p (h + 1 / s)) v_L."""
    (tmp_path / "s.yaml").write_text("""
duration_s: 25
period_ms: 5
road: {type: open}
fleet: {size: 2, length_m: 4, bumper_gap_m: 5, speed_mps: 25}
vehicle: {actuator_lag_s: 0.5}
control:
  model: GSBL
  parameters: {k_a: 0.5, k_v: 0.6, k_p: 0.5, headway_s: 2}
  desired_speed_mps: 25
  desired_bumper_gap_m: 5
  acceleration_limit_mps2: 9
  v2v_wait_ms: 0.3
  system_delay_ms: 0
channel: {latency: {distribution: fixed, mean_ms: 0}, frame_bytes: 200}
sensors: {error: 0}
events:
  - type: sine
    vehicle: 1
    at_s: 0
    duration_s: 25
    mean_mps: 25
    amplitude_mps: 1
    frequency_hz: 0.2
""")
    run = load(zenvoy.run(tmp_path / "s.yaml", engine="arrays", out=tmp_path / "run").log)
    assert set(run.estimate["mode"][:, 1]) == {pb.MODE_GSBL}
    s = 2j * np.pi * 0.2
    pull = 0.6 + 0.5 * (2.0 + 1.0 / s)
    expected = abs(pull / (0.5 * s * s + 1.5 * s + pull))
    first, second = np.ptp(run.truth["speed"][-1_000:], axis=0)
    assert second / first == pytest.approx(expected, rel=0.01)
