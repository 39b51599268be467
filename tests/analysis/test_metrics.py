"""Distances and agreement match hand calculations and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.analysis.measures.metrics import (
    accuracy,
    max_distance,
    meaningful_r2,
    min_distance,
)
from zenvoy.links.distance import gaps

POSITION = np.array([[100.0, 90.0, 60.0, 40.0, 10.0], [105.0, 90.0, 70.0, 50.0, 40.0]])


def test_gaps_of_the_ring_and_of_the_open_road() -> None:
    ring = [[60.0, 10.0, 30.0, 20.0, 30.0], [85.0, 15.0, 20.0, 20.0, 10.0]]
    np.testing.assert_array_equal(gaps(POSITION, 150.0), ring)
    opened = np.array(ring)
    opened[:, 0] = np.nan
    np.testing.assert_array_equal(gaps(POSITION, None), opened)


def test_distances_are_means_of_three_gaps() -> None:
    ring = gaps(POSITION, 150.0)
    np.testing.assert_allclose(min_distance(ring), [20.0, 15.0])  # 10 20 30, 10 15 20
    np.testing.assert_allclose(max_distance(ring), [40.0, 125.0 / 3.0])  # 60 30 30, 85 20 20
    opened = gaps(POSITION, None)  # without the first vehicle, which has no gap
    np.testing.assert_allclose(min_distance(opened), [20.0, 15.0])
    np.testing.assert_allclose(max_distance(opened), [80.0 / 3.0, 55.0 / 3.0])


def test_distances_of_fewer_than_three_gaps_are_means_of_all() -> None:
    opened = gaps(POSITION[:, :3], None)
    np.testing.assert_allclose(min_distance(opened), [20.0, 17.5])
    np.testing.assert_allclose(max_distance(opened), [20.0, 17.5])
    np.testing.assert_allclose(min_distance(gaps(POSITION[:, :2], None)), [10.0, 15.0])


@given(st.integers(3, 50))
def test_equal_spacing_gives_equal_distances_on_the_ring(size: int) -> None:
    position = np.arange(size, 0, -1.0)[None] * 37.5
    ring = gaps(position, size * 37.5)
    assert min_distance(ring) == max_distance(ring) == [37.5]


def test_fit_by_hand() -> None:
    found = accuracy(np.array([1.0, 2.0, 5.0, 4.0]), np.array([1.0, 2.0, 3.0, 4.0]))
    assert found is not None
    assert found.rmse == pytest.approx(1.0)  # √(4/4)
    assert found.r2 == pytest.approx(1.0 - 4.0 / 5.0)


def test_fit_of_perfect_values_and_of_the_mean() -> None:
    truth = np.array([[1.0, 2.0], [3.0, 6.0]])
    perfect = accuracy(truth, truth)
    assert perfect is not None
    assert perfect[:2] == (0.0, 1.0)
    assert perfect.spread == pytest.approx(np.std(truth))
    mean = accuracy(np.full((2, 2), 3.0), truth)
    assert mean is not None
    assert mean.r2 == pytest.approx(0.0)


def test_fit_uses_known_values_only() -> None:
    nan = np.nan
    assert accuracy(np.array([nan, 1.0]), np.array([1.0, nan])) is None
    found = accuracy(
        np.array([[nan, 2.0, 9.0], [3.0, 5.0, 7.0]]), np.array([[1, 2, nan], [3, 4, 7.0]])
    )
    assert found is not None
    assert found.rmse == pytest.approx(0.5)  # of 2 3 4 7: one is wrong by 1
    assert found.r2 == pytest.approx(1.0 - 1.0 / 14.0)


def test_r2_is_undefined_if_the_truth_does_not_vary() -> None:
    found = accuracy(np.array([29.0, 31.0]), np.array([30.0, 30.0]))
    assert found is not None
    assert found.rmse == 1.0
    assert found.spread == 0.0
    assert np.isnan(found.r2)
    assert meaningful_r2(found.r2) is None


def test_r2_below_0_is_left_out() -> None:
    """Readings of 30 m/s have errors of 3 %, and the fleet is nearly in steady motion."""
    truth = np.array([30.0, 30.01, 29.99, 30.0])
    found = accuracy(truth + np.array([0.5, -0.6, 0.7, -0.4]), truth)
    assert found is not None
    assert found.r2 < -1000.0
    assert meaningful_r2(found.r2) is None
    assert found.spread < found.rmse
    assert meaningful_r2(0.0) == 0.0
    assert meaningful_r2(0.98) == 0.98


@given(st.lists(st.tuples(st.floats(-100, 100), st.floats(-100, 100)), min_size=2, max_size=30))
def test_fit_agrees_with_numpy(pairs: list[tuple[float, float]]) -> None:
    values, truth = np.array(pairs).T
    found = accuracy(values, truth)
    assert found is not None
    assert found.rmse == pytest.approx(np.sqrt(np.mean((values - truth) ** 2)), abs=1e-12)
    if np.var(truth) > 1e-6:
        r2 = 1.0 - np.mean((values - truth) ** 2) / np.var(truth)
        assert found.r2 == pytest.approx(r2, rel=1e-9, abs=1e-9)
