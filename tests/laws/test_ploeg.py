"""Ploeg's CACC: values by hand, its filter in closed form, and the gap that it keeps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import zenvoy
from zenvoy.analysis.log.load import load
from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Observation, Output, Relative, Setpoint
from zenvoy.laws.library.ploeg import Parameters, headway

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=25.0)
LENGTH_M = 5.0
NAN = float("nan")


def decided(
    gap: float,
    relative_speed: float,
    command: float,
    before: float,
    own: Parameters,
    speed: float = 20.0,
    acceleration: float = 0.0,
    period_s: float = 0.01,
) -> Output:
    """Return what the law decides behind a vehicle that reports a command."""
    return headway(
        Observation(
            speed,
            SETPOINT,
            Relative(gap + LENGTH_M, relative_speed),
            predecessor=Motion(NAN, NAN, command=command),
            state=(before,),
            period_s=period_s,
            acceleration=acceleration,
            length_m=LENGTH_M,
        ),
        own,
    )


@pytest.mark.parametrize(
    ("gap", "relative_speed", "command", "before", "acceleration", "own", "a"),
    [
        # at rest: 2 m and 0.5 s at 20 m/s
        (12.0, 0.0, 0.0, 0.0, 0.0, Parameters(), 0.0),
        # T / h = 0.02 of k_p 10 m, of k_d (1 m/s - h 2 m/s²), of a command, and of the old one
        (22.0, 0.0, 0.0, 0.0, 0.0, Parameters(), 0.02 * 2.0),
        (12.0, 1.0, 0.0, 0.0, 2.0, Parameters(), 0.0),
        (12.0, 2.0, 0.0, 0.0, 2.0, Parameters(), 0.02 * 0.7),
        (12.0, 0.0, -3.0, 0.0, 0.0, Parameters(), -0.06),
        (12.0, 0.0, 0.0, 1.0, 0.0, Parameters(), 0.98),
        (7.0, -1.0, -0.5, -0.4, 0.0, Parameters(0.4, 0.6, 0.2, 5.0), -0.4 + 0.05 * (-1.5)),
        # the first decision starts at the own acceleration
        (11.0, 0.5, 0.0, NAN, 1.0, Parameters(), 1.0 + 0.02 * (-1.0 - 0.2)),
    ],
)
def test_command_by_hand(
    gap: float,
    relative_speed: float,
    command: float,
    before: float,
    acceleration: float,
    own: Parameters,
    a: float,
) -> None:
    output = decided(gap, relative_speed, command, before, own, acceleration=acceleration)
    assert output.acceleration == pytest.approx(a, abs=1e-12)
    assert output.state == (output.acceleration,)


@given(st.floats(0.1, 3.0), st.floats(-5.0, 5.0), st.integers(1, 300))
def test_the_command_ahead_is_filtered_with_the_headway(
    headway_s: float, command: float, steps: int
) -> None:
    """u_n = u₁ (1 - (1 - T / h)^n), which is 1 - e^(-t / h) for a short period T."""
    own, u = Parameters(headway_s=headway_s), 0.0
    for _ in range(steps):
        u = decided(2.0 + 20.0 * headway_s, 0.0, command, u, own).acceleration
    assert u == pytest.approx(command * (1.0 - (1.0 - 0.01 / headway_s) ** steps), abs=1e-9)


@given(st.floats(1e-3, 0.1), st.floats(-3.0, 3.0))
def test_a_headway_below_the_period_is_no_overshoot(headway_s: float, command: float) -> None:
    own = Parameters(headway_s=headway_s)
    u = decided(2.0 + 20.0 * headway_s, 0.0, command, 7.0, own, period_s=0.1).acceleration
    assert u == pytest.approx(command, abs=1e-9)


SCENARIO = """
duration_s: 40
period_ms: 20
road: {type: open}
fleet: {size: 4, bumper_gap_m: 20, speed_mps: 20, groups: [{name: mute, vehicles: 3, beacons: %s}]}
control: {model: Ploeg, parameters: {headway_s: 0.8, standstill_m: 3}, system_delay_ms: 5}
sensors: {error: 0}
"""


def test_the_gap_becomes_that_of_the_headway(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO % "true")
    run = load(zenvoy.run(tmp_path / "s.yaml", engine="arrays", out=tmp_path / "run").log)
    gap = -np.diff(run.truth["position"][-1]) - 5.0
    assert gap == pytest.approx([19.0] * 3, abs=1e-3)
    assert set(run.estimate["mode"][1:, 1:].ravel()) == {pb.MODE_PLOEG}


def test_a_vehicle_behind_one_without_a_radio_falls_back(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENARIO % "false")
    run = zenvoy.run(tmp_path / "s.yaml", engine="arrays", out=tmp_path / "run")
    modes = load(run.log).estimate["mode"][1]
    assert list(modes[1:]) == [pb.MODE_PLOEG, pb.MODE_PLOEG, pb.MODE_FALLBACK_FM]
