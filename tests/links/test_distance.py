"""Gaps and distances along the road agree with their plain definitions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.links.distance import distance, forward, gaps

RING_M = 1_000.0
quarters = st.integers(-40_000, 40_000).map(lambda k: k / 4)  # exact in binary


@given(quarters, quarters)
def test_a_distance_on_the_ring_is_the_shorter_way(one: float, other: float) -> None:
    laps = range(-25, 26)
    expected = min(abs(one - other + lap * RING_M) for lap in laps)
    assert float(distance(np.array(one), np.array(other), RING_M)) == expected
    assert float(distance(np.array(other), np.array(one), RING_M)) == expected
    assert float(distance(np.array(one), np.array(other), None)) == abs(one - other)


def test_forward_distance_is_one_way() -> None:
    ahead, behind = np.array([990.0, 10.0]), np.array([10.0, 990.0])
    assert forward(ahead, behind, RING_M).tolist() == [980.0, 20.0]


@pytest.mark.parametrize("ring_m", [None, RING_M])
def test_gaps_of_many_instants_are_those_of_each(ring_m: float | None) -> None:
    position = np.random.default_rng(1).uniform(0.0, RING_M, (5, 4))
    together = gaps(position, ring_m)
    for instant, found in zip(position, together, strict=True):
        np.testing.assert_array_equal(found, gaps(instant, ring_m))


def test_gaps_on_the_ring_add_up_to_its_length() -> None:
    assert gaps(np.array([2_310.0, 2_280.0, 2_275.0]), RING_M).sum() == RING_M
    assert gaps(np.array([310.0, 280.0, 275.0]), RING_M).tolist() == [965.0, 30.0, 5.0]
    np.testing.assert_array_equal(gaps(np.array([310.0, 280.0]), None), [np.nan, 30.0])


def test_a_gap_is_not_a_distance() -> None:
    """A follower that has run past its leader has a gap below 0."""
    position = np.array([100.0, 103.0])
    assert gaps(position, None)[1] == -3.0
    assert distance(position[0], position[1], None) == 3.0
