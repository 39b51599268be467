"""Vehicles whose acceleration lags behind its command move as the differential equation says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tests.commanding import give
from zenvoy.scenarios import Brake, Control, Group, Road, Scenario, Vehicle
from zenvoy.scenarios import Fleet as FleetSettings
from zenvoy.world.actuators import Actuators
from zenvoy.world.fleet import Fleet

MS_NS = 1_000_000


def solved(v: float, a: float, u: float, lag_s: float, dt_s: float) -> tuple[float, float]:
    """Return the distance (m) and the speed (m/s) by a solver of differential equations.

    A vehicle that stands stays there while its actuator gives less than 0.
    """

    def slope(_: float, state: np.ndarray) -> list[float]:
        _x, speed, acceleration = state
        stands = speed <= 0.0 and acceleration < 0.0
        return [max(speed, 0.0), 0.0 if stands else acceleration, (u - acceleration) / lag_s]

    found = solve_ivp(slope, (0.0, dt_s), [0.0, v, a], max_step=dt_s / 4_000, rtol=1e-9, atol=1e-12)
    x, speed, _ = found.y[:, -1]
    return float(x), float(speed)


accelerations = st.floats(-8.0, 8.0).map(lambda a: round(a, 3))


@given(
    st.floats(0.0, 3.0).map(lambda v: round(v, 3)),
    accelerations,
    accelerations,
    st.floats(0.05, 2.0).map(lambda lag_s: round(lag_s, 3)),
    st.sampled_from([0.01, 0.1, 1.0]),
)
def test_motion_is_that_of_a_solver_of_differential_equations(
    v: float, a: float, u: float, lag_s: float, dt_s: float
) -> None:
    """Many of these vehicles come to a standstill, and some of them move off again."""
    actuators = Actuators(np.array([lag_s]))
    actuators.acceleration[0] = a
    position, speed = actuators.advance(np.zeros(1), np.array([v]), np.array([u]), dt_s)
    x, after = solved(v, a, u, lag_s, dt_s)
    assert position[0] == pytest.approx(x, abs=3e-3)
    assert speed[0] == pytest.approx(after, abs=5e-3)
    assert actuators.acceleration[0] == pytest.approx(u + (a - u) * math.exp(-dt_s / lag_s))


@given(
    st.lists(st.tuples(accelerations, accelerations), min_size=1, max_size=6),
    st.floats(0.0, 3.0),
    st.floats(0.05, 2.0),
    st.integers(1, 99),
)
def test_motion_does_not_depend_on_how_time_is_cut(
    pairs: list[tuple[float, float]], v: float, lag_s: float, percent: int
) -> None:
    a, u = (np.array(column) for column in zip(*pairs, strict=True))
    whole, cut = (Actuators(np.full(len(pairs), lag_s)) for _ in range(2))
    whole.acceleration, cut.acceleration = a.copy(), a.copy()
    start = np.zeros(len(pairs)), np.full(len(pairs), v)
    at_once = whole.advance(*start, u, 0.1)
    first = cut.advance(*start, u, 0.001 * percent)
    in_two = cut.advance(*first, u, 0.1 - 0.001 * percent)
    for one, other in zip(at_once, in_two, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(whole.acceleration, cut.acceleration, rtol=0.0, atol=1e-9)


@given(accelerations, accelerations, st.floats(0.0, 3.0), st.floats(0.05, 2.0))
def test_no_vehicle_drives_backwards(a: float, u: float, v: float, lag_s: float) -> None:
    actuators = Actuators(np.array([lag_s]))
    actuators.acceleration[0] = a
    position, speed = np.zeros(1), np.array([v])
    for _ in range(20):
        before = position
        position, speed = actuators.advance(position, speed, np.array([u]), 0.1)
        assert speed[0] >= 0.0
        assert position[0] >= before[0] - 1e-12


def fleet(*groups: Group, lag_s: float | None = None, brakes: tuple[Brake, ...] = ()) -> Fleet:
    return Fleet(
        Scenario(
            road=Road(type="open"),
            fleet=FleetSettings(size=3, gap_m=1_000.0, speed_mps=20.0, groups=groups),
            vehicle=Vehicle(actuator_lag_s=lag_s, max_deceleration_mps2=8.0),
            control=Control(model="FM"),
            events=brakes,
        )
    )


def command_all(moved: Fleet, a: float) -> None:
    give(moved, ((v, 0, a) for v in (1, 2, 3)))


def test_each_vehicle_has_its_own_lag_and_limits() -> None:
    quick = Group(name="quick", vehicles="2", vehicle=Vehicle(max_acceleration_mps2=5.0))
    slow = Group(name="slow", vehicles="3", vehicle=Vehicle(actuator_lag_s=1.0))
    moved = fleet(quick, slow)
    command_all(moved, 9.0)
    moved.advance_to(1_000 * MS_NS)
    after_one_lag = 1.0 - math.exp(-1.0)
    np.testing.assert_allclose(moved.acceleration, [3.0, 5.0, 3.0 * after_one_lag])
    np.testing.assert_allclose(moved.speed, [23.0, 25.0, 20.0 + 3.0 * (1.0 - after_one_lag)])
    command_all(moved, -9.0)
    moved.advance_to(1_001 * MS_NS)
    assert moved.acceleration.tolist()[:2] == [-8.0, -8.0]


def test_without_a_lag_the_bits_are_those_of_before() -> None:
    """Also for those without one in a fleet in which others have one."""
    slow = Group(name="slow", vehicles="3", vehicle=Vehicle(actuator_lag_s=1.0))
    plain, mixed = fleet(), fleet(slow)
    for moved in (plain, mixed):
        command_all(moved, 1.1)
        moved.advance_to(333 * MS_NS)
    assert plain.position.tolist()[:2] == mixed.position.tolist()[:2]
    assert plain.speed.tolist()[:2] == mixed.speed.tolist()[:2]
    assert plain.speed[2] != mixed.speed[2]


def test_a_braking_of_the_scenario_acts_at_once_and_the_lag_goes_on_from_it() -> None:
    brake = Brake(vehicle=2, at_s=1.0, duration_s=1.0, deceleration_mps2=6.0)
    moved = fleet(lag_s=0.5, brakes=(brake,))
    moved.advance_to(1_500 * MS_NS)
    assert moved.speed.tolist() == pytest.approx([20.0, 17.0, 20.0])
    moved.advance_to(2_500 * MS_NS)
    assert moved.acceleration[1] == pytest.approx(-6.0 * math.exp(-1.0))
    assert moved.speed[1] == pytest.approx(14.0 - 6.0 * 0.5 * (1.0 - math.exp(-1.0)))
