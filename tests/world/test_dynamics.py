"""Motion under constant acceleration is exact, and ends at a standstill."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.world.dynamics import acting, advance

Floats = NDArray[np.float64]


def exact(p: float, v: float, a: float, dt: float) -> tuple[float, float]:
    """Move one vehicle by the closed form. It stops after v² / 2|a|."""
    if a < 0.0 and v + a * dt < 0.0:
        return p + v * v / (-2.0 * a), 0.0
    return p + v * dt + a * dt * dt / 2.0, v + a * dt


vehicles = st.lists(
    st.tuples(st.floats(-1e3, 1e3), st.floats(0.0, 40.0), st.floats(-9.0, 9.0)),
    min_size=1,
    max_size=6,
)


@given(vehicles, st.floats(0.0, 30.0))
def test_agrees_with_the_closed_form(fleet: list[tuple[float, float, float]], dt_s: float) -> None:
    position, speed, a = np.array(fleet).T
    moved, after = advance(position, speed, a, dt_s)
    truth = np.array([exact(*vehicle, dt_s) for vehicle in fleet]).T
    np.testing.assert_allclose(moved, truth[0], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(after, truth[1], rtol=1e-12, atol=1e-9)
    assert (after >= 0.0).all()


@settings(deadline=None)
@given(vehicles, st.lists(st.floats(0.0, 2.0), min_size=1, max_size=40))
def test_many_small_steps_are_one_large_one(
    fleet: list[tuple[float, float, float]], steps_s: list[float]
) -> None:
    position, speed, a = np.array(fleet).T
    at_once = advance(position, speed, a, sum(steps_s))
    for dt_s in steps_s:
        position, speed = advance(position, speed, acting(speed, a), dt_s)
        assert (speed >= 0.0).all()
    np.testing.assert_allclose(position, at_once[0], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(speed, at_once[1], rtol=1e-12, atol=1e-9)


def test_motion_by_hand() -> None:
    position, speed = advance(
        np.array([0.0, 0.0, 10.0, 0.0]),
        np.array([10.0, 3.0, 0.0, 6.0]),
        np.array([2.0, -3.0, -3.0, -3.0]),
        2.0,
    )
    assert position.tolist() == [24.0, 1.5, 10.0, 6.0]  # stops after 1 s; stands; stops at the end
    assert speed.tolist() == [14.0, 0.0, 0.0, 0.0]


def test_arguments_are_not_changed() -> None:
    position, speed, a = np.array([0.0]), np.array([3.0]), np.array([-3.0])
    advance(position, speed, a, 2.0)
    assert (position.item(), speed.item(), a.item()) == (0.0, 3.0, -3.0)


@pytest.mark.parametrize(
    ("speed", "a", "acts"), [(0.0, -3.0, 0.0), (0.0, 2.0, 2.0), (0.1, -3.0, -3.0), (0.0, 0.0, 0.0)]
)
def test_braking_does_nothing_to_a_vehicle_that_stands(speed: float, a: float, acts: float) -> None:
    assert acting(np.array([speed]), np.array([a])).tolist() == [acts]
