"""IDM: values by hand, its equilibrium, its linear form, and the limit of its string stability."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.analysis.theory.laws import is_string_stable, peak_gain
from zenvoy.laws import Observation, Relative, Setpoint, law_of
from zenvoy.laws.library.idm import (
    Parameters,
    equilibrium_gap_m,
    intelligent_driver,
    stable_acceleration_mps2,
)
from zenvoy.scenarios import Gains

SETPOINT = Setpoint(k_d=0.1, k_v=0.5, k_c=0.05, p_des=37.5, v_des=25.0)
LENGTH_M = 5.0
OWN = Parameters(free_speed_mps=30.0, headway_s=1.5, acceleration_mps2=1.5, deceleration_mps2=1.5)

drivers = st.builds(
    Parameters,
    free_speed_mps=st.floats(20.0, 45.0),
    headway_s=st.floats(0.5, 2.5),
    standstill_m=st.floats(1.0, 5.0),
    acceleration_mps2=st.floats(0.3, 3.0),
    deceleration_mps2=st.floats(0.5, 4.0),
    exponent=st.integers(1, 8),
)
speeds = st.floats(0.0, 19.0)


def acceleration(speed: float, gap: float, relative_speed: float, own: Parameters) -> float:
    """Return the acceleration of a driver with a gap from bumper to bumper, m."""
    ahead = Relative(gap + LENGTH_M, relative_speed)
    return float(intelligent_driver(Observation(speed, SETPOINT, ahead, length_m=LENGTH_M), own))


def gains(own: Parameters, speed: float) -> Gains:
    linear = law_of("IDM").linear
    assert linear is not None
    _, _, k_d, k_v, k_c = linear(own, SETPOINT._replace(v_des=speed), 0)
    return Gains(k_d=k_d, k_v=k_v, k_c=k_c)


@pytest.mark.parametrize(
    ("speed", "gap", "relative_speed", "a"),
    [
        (0.0, 1e9, 0.0, 1.5),  # from rest on a free road
        (30.0, 1e9, 0.0, 0.0),  # as fast as it wants to be
        (15.0, 1e9, 0.0, 1.5 * (1.0 - 0.5**4)),
        (0.0, 2.0, 0.0, 0.0),  # at rest behind a car at rest
        (0.0, 4.0, 0.0, 1.5 * 0.75),
        # s* = 2 + 1.5 · 15 + 15 · 3 / (2 · 1.5) = 39.5
        (15.0, 39.5, -3.0, 1.5 * -(0.5**4)),
        # The car ahead is faster: the desired gap is s0, not less.
        (15.0, 20.0, 9.0, 1.5 * (1.0 - 0.5**4 - 0.01)),
    ],
)
def test_acceleration_by_hand(speed: float, gap: float, relative_speed: float, a: float) -> None:
    assert acceleration(speed, gap, relative_speed, OWN) == pytest.approx(a, abs=1e-9)


@pytest.mark.parametrize("gap", [0.1, 0.0, -4.0])
def test_a_driver_without_a_gap_brakes_hard_and_not_without_bounds(gap: float) -> None:
    assert acceleration(20.0, gap, 0.0, OWN) == acceleration(20.0, 0.1, 0.0, OWN) < -1e5


@given(drivers, speeds)
def test_the_acceleration_is_zero_in_equilibrium(own: Parameters, speed: float) -> None:
    gap = equilibrium_gap_m(own, speed)
    assert acceleration(speed, gap, 0.0, own) == pytest.approx(0.0, abs=1e-9)
    assert acceleration(speed, 1.1 * gap, 0.0, own) > 0.0


def test_no_gap_is_wide_enough_at_the_speed_of_a_free_road() -> None:
    assert equilibrium_gap_m(OWN, 30.0) == equilibrium_gap_m(OWN, 31.0) == math.inf
    assert gains(OWN, 31.0).k_d == 0.0


@given(drivers, speeds)
def test_the_linear_form_has_the_slopes_of_the_law(own: Parameters, speed: float) -> None:
    speed, gap, step = speed + 0.5, equilibrium_gap_m(own, speed + 0.5), 1e-4
    slopes = [
        (acceleration(speed, gap + step, 0.0, own) - acceleration(speed, gap - step, 0.0, own)),
        (acceleration(speed, gap, step, own) - acceleration(speed, gap, -step, own)),
        (acceleration(speed - step, gap, 0.0, own) - acceleration(speed + step, gap, 0.0, own)),
    ]
    found = gains(own, speed)
    expected = [slope / (2.0 * step) for slope in slopes]
    assert [found.k_d, found.k_v, found.k_c] == pytest.approx(expected, rel=1e-4, abs=1e-6)


@given(drivers, speeds)
def test_strings_are_stable_above_the_limit_and_not_below(own: Parameters, speed: float) -> None:
    limit = stable_acceleration_mps2(own, speed)
    above, below = (replace(own, acceleration_mps2=share * limit) for share in (1.001, 0.999))
    assert is_string_stable(gains(above, speed))
    assert not is_string_stable(gains(below, speed))
    assert peak_gain(gains(replace(own, acceleration_mps2=0.5 * limit), speed)).gain > 1.0


def test_the_limit_at_rest_is_that_of_treiber_and_kesting() -> None:
    """They give a ≥ s0 / T² for the limit of dense traffic."""
    assert stable_acceleration_mps2(OWN, 0.0) == pytest.approx(2.0 / 1.5**2)
    assert stable_acceleration_mps2(replace(OWN, headway_s=0.0), 0.0) == math.inf
