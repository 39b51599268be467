"""Consensus: values by hand, delays of links made good, and the distances of a platoon."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Observation, Setpoint
from zenvoy.laws.library.consensus import Parameters, consensus

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=25.0)
LENGTH_M = 4.0
LINK_M = 0.8 * 20.0 + 15.0 + LENGTH_M  # at 20 m/s


def report(distance: float, steps: int, v: float = 20.0, age_s: float = 0.0) -> Motion:
    return Motion(v, 0.0, distance, age_s, steps=steps)


def acceleration(
    leader: Motion, predecessor: Motion, speed: float = 20.0, own: Parameters | None = None
) -> float:
    seen = Observation(speed, SETPOINT, predecessor=predecessor, leader=leader, length_m=LENGTH_M)
    return float(consensus(seen, own or Parameters()))


@pytest.mark.parametrize(
    ("leader", "predecessor", "speed", "a"),
    [
        (report(3 * LINK_M, 3), report(LINK_M, 1), 20.0, 0.0),
        (report(3 * LINK_M, 3), report(LINK_M, 1), 19.0, 1.8),
        # one of two links: half of 0.08 · 5 m, and half of 0.86 · 2 m
        (report(3 * LINK_M + 5.0, 3), report(LINK_M, 1), 20.0, 0.2),
        (report(3 * LINK_M, 3), report(LINK_M - 2.0, 1), 20.0, -0.86),
        # the vehicle ahead is the leader: one link, with its own gain
        (report(LINK_M + 1.0, 1), report(LINK_M + 1.0, 1), 20.0, 0.46),
        # a faster leader: 0.8 s more on each of three links, and on the one to the vehicle ahead
        (report(3 * LINK_M, 3, v=21.0), report(LINK_M, 1), 20.0, 1.8 - 0.04 * 2.4 - 0.43 * 0.8),
    ],
)
def test_acceleration_by_hand(leader: Motion, predecessor: Motion, speed: float, a: float) -> None:
    assert acceleration(leader, predecessor, speed) == pytest.approx(a, abs=1e-12)


@given(st.integers(2, 9), st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 40.0))
def test_the_delay_of_each_link_is_made_good(
    steps: int, of_leader_s: float, of_ahead_s: float, v: float
) -> None:
    """In a platoon at one speed, a report that is older by τ shows a distance shorter by v τ."""
    link = 0.8 * v + 15.0 + LENGTH_M
    leader = report(steps * link - v * of_leader_s, steps, v, of_leader_s)
    ahead = report(link - v * of_ahead_s, 1, v, of_ahead_s)
    assert acceleration(leader, ahead, v) == pytest.approx(0.0, abs=1e-9)


@given(st.integers(1, 9), st.floats(0.0, 40.0), st.floats(0.0, 3.0), st.floats(0.0, 30.0))
def test_distances_are_those_of_headway_and_standstill(
    steps: int, v: float, headway_s: float, standstill_m: float
) -> None:
    own = Parameters(headway_s=headway_s, standstill_m=standstill_m)
    link = headway_s * v + standstill_m + LENGTH_M
    leader, ahead = report(steps * link, steps, v), report(link, 1, v)
    assert acceleration(leader, ahead, v, own) == pytest.approx(0.0, abs=1e-9)


def test_a_platoon_finds_its_distances_with_late_reports(tmp_path: Path) -> None:
    """Two platoons of three: the first vehicle of the second one follows as ever."""
    (tmp_path / "s.yaml").write_text("""
duration_s: 60
period_ms: 50
road: {type: open}
fleet: {size: 6, length_m: 4, bumper_gap_m: 30, speed_mps: 20}
control:
  model: Consensus
  desired_speed_mps: 20
  desired_bumper_gap_m: 40
  system_delay_ms: 0
  platoon: {size: 3}
channel: {latency: {distribution: uniform, min_ms: 20, max_ms: 300}}
sensors: {error: 0}
""")
    run = load(zenvoy.run(tmp_path / "s.yaml", engine="arrays", out=tmp_path / "run").log)
    gap = -np.diff(run.truth["position"][-1]) - 4.0
    assert gap == pytest.approx([31.0, 31.0, 40.0, 31.0, 31.0], abs=0.02)
    modes = run.estimate["mode"][-1].tolist()
    consents = pb.MODE_CONSENSUS
    leads = [pb.MODE_CONSTANT_SPEED, consents, consents]
    assert modes == [*leads, pb.MODE_FM, consents, consents]
