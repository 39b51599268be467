"""ACC: values by hand, its equilibrium, and its linear form."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.laws import Observation, Relative, Setpoint, law_of
from zenvoy.laws.library.acc import Parameters, constant_headway

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=25.0)
LENGTH_M = 5.0


def acceleration(speed: float, gap: float, relative_speed: float, own: Parameters) -> float:
    """Return the acceleration of a vehicle with a gap from bumper to bumper, m."""
    ahead = Relative(gap + LENGTH_M, relative_speed)
    seen = Observation(speed, SETPOINT, ahead, length_m=LENGTH_M)
    return float(constant_headway(seen, own))


@pytest.mark.parametrize(
    ("speed", "gap", "relative_speed", "own", "a"),
    [
        # Rajamani, Eq. 6.18, with the 2 m that Plexe adds: -(1/h) (v - v_ahead + λ (h v + 2 - gap))
        (25.0, 42.0, 0.0, Parameters(), 0.1 / 1.2 * 10.0),
        (25.0, 32.0, -3.0, Parameters(), -2.5),
        (20.0, 26.0, 1.2, Parameters(), 1.0),
        (0.0, 1.0, 0.0, Parameters(), -0.1 / 1.2),
        (10.0, 8.0, 0.3, Parameters(0.3, 0.2, 0.0), (0.3 + 0.2 * 5.0) / 0.3),
    ],
)
def test_acceleration_by_hand(
    speed: float, gap: float, relative_speed: float, own: Parameters, a: float
) -> None:
    assert acceleration(speed, gap, relative_speed, own) == pytest.approx(a, abs=1e-12)


@given(st.floats(0.0, 50.0), st.floats(0.1, 3.0), st.floats(0.01, 2.0), st.floats(0.0, 10.0))
def test_the_gap_is_that_of_the_headway_in_equilibrium(
    speed: float, headway_s: float, rate: float, standstill_m: float
) -> None:
    own = Parameters(headway_s, rate, standstill_m)
    gap = standstill_m + headway_s * speed
    assert acceleration(speed, gap, 0.0, own) == pytest.approx(0.0, abs=1e-9)
    assert acceleration(speed, gap + 1.0, 0.0, own) > 0.0


def test_the_linear_form_is_the_law_itself() -> None:
    law, own = law_of("ACC"), Parameters(0.8, 0.25, 3.0)
    assert law.linear is not None
    ahead, behind, k_d, k_v, k_c = law.linear(own, SETPOINT, 0)
    assert (ahead, behind) == ((1.0,), ())
    rest = acceleration(25.0, 23.0, 0.0, own)
    assert acceleration(25.0, 24.0, 0.0, own) - rest == pytest.approx(k_d, abs=1e-12)
    assert acceleration(25.0, 23.0, 1.0, own) - rest == pytest.approx(k_v, abs=1e-12)
    assert acceleration(26.0, 23.0, 0.0, own) - rest == pytest.approx(-k_c, abs=1e-12)


def test_the_transfer_is_that_of_a_first_order_lag_of_the_headway() -> None:
    """1 / (h s + 1), which never amplifies: the law cancels its own pole at -λ."""
    law = law_of("ACC")
    assert law.linear is not None
    for headway_s, rate in ((0.3, 0.1), (1.2, 0.1), (2.0, 1.5)):
        _, _, k_d, k_v, k_c = law.linear(Parameters(headway_s, rate), SETPOINT, 0)
        for omega in (0.01, 0.3, 2.0):
            s = 1j * omega
            transfer = (k_v * s + k_d) / (s * s + (k_v + k_c) * s + k_d)
            assert transfer == pytest.approx(1.0 / (headway_s * s + 1.0), abs=1e-12)
