"""The road computes gaps and separates vehicles that collide."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.world.road import Road

Floats = NDArray[np.float64]

LENGTH_M = 5.0


def test_gaps_by_hand() -> None:
    position = np.array([100.0, 70.0, 65.0])
    np.testing.assert_array_equal(Road(None).gaps(position), [np.nan, 30.0, 5.0])
    np.testing.assert_array_equal(Road(200.0).gaps(position), [165.0, 30.0, 5.0])


def test_vehicles_with_room_are_not_moved() -> None:
    position, speed = np.array([100.0, 95.0, 80.0]), np.array([1.0, 2.0, 3.0])
    for road in (Road(None), Road(200.0)):
        after, speeds, moved = road.separate(position, speed, LENGTH_M)
        assert moved == []
        np.testing.assert_array_equal(after, position)
        np.testing.assert_array_equal(speeds, speed)


def test_a_follower_that_collides_is_put_at_the_bumper_of_its_leader_with_its_speed() -> None:
    position, speed = np.array([100.0, 96.0, 80.0]), np.array([10.0, 20.0, 30.0])
    after, speeds, moved = Road(None).separate(position, speed, LENGTH_M)
    assert moved == [1]
    assert after.tolist() == [100.0, 95.0, 80.0]
    assert speeds.tolist() == [10.0, 10.0, 30.0]
    assert position.tolist() == [100.0, 96.0, 80.0]  # the argument is not changed


def test_a_pile_up_goes_on_from_one_to_the_next() -> None:
    position, speed = np.array([100.0, 96.0, 92.0, 88.0]), np.array([1.0, 2.0, 3.0, 4.0])
    after, speeds, moved = Road(None).separate(position, speed, LENGTH_M)
    assert moved == [1, 2, 3]
    assert after.tolist() == [100.0, 95.0, 90.0, 85.0]
    assert speeds.tolist() == [1.0] * 4


def test_a_pile_up_goes_across_the_seam_of_the_ring() -> None:
    """Vehicle 1 follows the last one, touches it, and is then in the way of vehicle 2."""
    position = np.array([99.0, 95.0, 60.0, 2.0])
    after, speeds, moved = Road(100.0).separate(position, np.array([9.0, 8.0, 7.0, 1.0]), LENGTH_M)
    assert sorted(moved) == [0, 1]
    assert after.tolist() == [97.0, 92.0, 60.0, 2.0]
    assert speeds.tolist() == [1.0, 1.0, 7.0, 1.0]


@st.composite
def crowds(draw: st.DrawFn) -> tuple[float | None, Floats, Floats]:
    """Draw a road with room for all vehicles, and vehicles in order with any gaps between."""
    gaps = draw(st.lists(st.floats(-20.0, 60.0), min_size=2, max_size=8))
    position = draw(st.floats(-1e4, 1e4)) - np.cumsum([0.0, *gaps])
    speed = draw(st.lists(st.floats(0.0, 40.0), min_size=len(gaps) + 1, max_size=len(gaps) + 1))
    ring_length_m = None
    if draw(st.booleans()):
        room = LENGTH_M * len(position) + 0.01
        seam = draw(st.floats(-20.0, 60.0))
        ring_length_m = max(room, float(position[0] - position[-1]) + seam)
    return ring_length_m, position, np.array(speed)


@settings(deadline=None, max_examples=400)
@given(crowds())
def test_after_separation_all_have_room(crowd: tuple[float | None, Floats, Floats]) -> None:
    ring_length_m, position, speed = crowd
    road = Road(ring_length_m)
    after, speeds, moved = road.separate(position, speed, LENGTH_M)
    gaps = road.gaps(after)
    if ring_length_m is None:
        assert math.isnan(gaps[0])
        assert after[0] == position[0]  # nobody is ahead of it
        gaps[0] = np.inf
    else:
        assert gaps.sum() == pytest.approx(ring_length_m, abs=1e-6)
    assert (gaps >= LENGTH_M - 1e-8).all()
    assert (after <= position).all()  # put back, never forward
    assert len(set(moved)) == len(moved)
    for i in range(len(position)):
        if i in moved:
            assert gaps[i] == pytest.approx(LENGTH_M, abs=1e-8)
            assert speeds[i] == speeds[i - 1]
        else:
            assert (after[i], speeds[i]) == (position[i], speed[i])
    assert road.separate(after, speeds, LENGTH_M)[2] == []  # once is enough
