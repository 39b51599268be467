"""FollowerStopper: the values of the paper, and its piecewise form."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.laws import Observation, Relative, Setpoint
from zenvoy.laws.library.follower_stopper import Parameters, commanded_speed, stopping

LENGTH_M = 5.0
U_MPS = 7.0


def seen(speed: float, gap: float, relative_speed: float) -> Observation:
    """Return what a vehicle sees with a gap from bumper to bumper, m."""
    setpoint = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=U_MPS)
    return Observation(speed, setpoint, Relative(gap + LENGTH_M, relative_speed), length_m=LENGTH_M)


def as_printed(speed: float, gap: float, relative_speed: float) -> float:
    """Return the commanded speed as the paper prints it, Eqs. 1 and 2."""
    closing = min(relative_speed, 0.0)
    x1, x2, x3 = (x0 + closing**2 / (2.0 * d) for x0, d in ((4.5, 1.5), (5.25, 1.0), (6.0, 0.5)))
    v = min(max(speed + relative_speed, 0.0), U_MPS)
    if gap <= x1:
        return 0.0
    if gap <= x2:
        return v * (gap - x1) / (x2 - x1)
    if gap <= x3:
        return v + (U_MPS - v) * (gap - x2) / (x3 - x2)
    return U_MPS


@given(st.floats(0.0, 12.0), st.floats(0.0, 40.0), st.floats(-12.0, 12.0))
def test_the_command_is_that_of_the_paper(speed: float, gap: float, relative: float) -> None:
    found = commanded_speed(seen(speed, gap, relative), Parameters())
    assert found == pytest.approx(as_printed(speed, gap, relative), abs=1e-9)


def test_boundaries_move_with_the_closing_speed() -> None:
    """At -3 m/s they are at 7.5, 9.75 and 15 m, as the paper says."""
    own = Parameters()
    assert commanded_speed(seen(7.0, 7.5, -3.0), own) == 0.0
    assert commanded_speed(seen(7.0, 9.75, -3.0), own) == pytest.approx(4.0)
    assert commanded_speed(seen(7.0, 15.0, -3.0), own) == pytest.approx(7.0)


def test_the_host_takes_on_the_command_in_its_time() -> None:
    assert stopping(seen(6.0, 50.0, 0.0), Parameters()) == pytest.approx(2.0)
    assert stopping(seen(6.0, 50.0, 0.0), Parameters(tracking_s=2.0)) == pytest.approx(0.5)
    assert stopping(seen(7.0, 50.0, 0.0), Parameters()) == 0.0


@pytest.mark.parametrize("wrong", [{"gap_2_m": 4.5}, {"gap_3_m": 5.0}, {"d_2_mps2": 1.6}])
def test_boundaries_that_cross_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        Parameters(**wrong)
