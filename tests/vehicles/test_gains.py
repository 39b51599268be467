"""The graph of covariances is shared, settles, and stays right once it is full."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.vehicles.estimator import Filter
from zenvoy.vehicles.gains import Covariance, GainSchedule, _transcribed, gain_schedule, settle

Floats = NDArray[np.float64]

PERIOD_S, ACCELERATION_STD = 0.1, 0.5
VARIANCES = (4.6875, 3.0)
F = np.array([[1.0, PERIOD_S], [0.0, 1.0]])
B = np.array([[PERIOD_S**2 / 2], [PERIOD_S]])
Q = ACCELERATION_STD**2 * B @ B.T
R = np.diag(VARIANCES)


@pytest.fixture(autouse=True)
def _unused_graphs() -> None:
    """Empty the graphs. Tests of other modules may have filled that of this model."""
    gain_schedule.cache_clear()


def riccati(before: Floats, periods: int) -> tuple[Floats, Floats]:
    """Return P and K after `periods` predictions and an update, by the textbook."""
    p = before
    for _ in range(periods):
        p = F @ p @ F.T + Q
    gain = p @ np.linalg.inv(p + R)
    return (np.eye(2) - gain) @ p, gain


def fresh() -> GainSchedule:
    return GainSchedule(PERIOD_S, ACCELERATION_STD, VARIANCES)


def settled(schedule: GainSchedule, point: Covariance) -> Covariance:
    for _ in range(3_000):
        after = schedule.step(point, 1)
        if after is point:
            return point
        point = after
    raise AssertionError("did not settle")


def test_filters_of_the_same_model_share_what_they_compute() -> None:
    variances = (2.5, 1.25)  # of no other test, since a graph keeps a limited number of points
    first, second = Filter(PERIOD_S, ACCELERATION_STD), Filter(PERIOD_S, ACCELERATION_STD)
    for k in range(20):
        inputs = (0.5,) * (1 + k % 3)
        first.step(inputs, (37.5, 0.0 + k), variances)
        second.step(inputs, (30.0, 1.0 - k), variances)
        assert first.P is second.P
    assert first.x != second.x


def test_different_models_share_nothing() -> None:
    shared = gain_schedule(PERIOD_S, ACCELERATION_STD, VARIANCES)
    assert gain_schedule(PERIOD_S, ACCELERATION_STD, VARIANCES) is shared
    for other in ((0.2, 0.5, VARIANCES), (0.1, 0.6, VARIANCES), (0.1, 0.5, (3.0, 4.6875))):
        assert gain_schedule(*other) is not shared


def test_the_schedule_starts_with_the_covariance_of_a_reading() -> None:
    np.testing.assert_array_equal(fresh().first.P, R)
    assert fresh().first.std == pytest.approx(np.sqrt(VARIANCES), rel=1e-15)


def test_the_schedule_settles_into_a_fixed_point() -> None:
    schedule = fresh()
    point = settled(schedule, schedule.first)
    P, K = riccati(point.P, 1)
    np.testing.assert_allclose(P, point.P, rtol=1e-11)
    np.testing.assert_allclose(K, point.K, rtol=1e-11)
    # Any history leads to an equal point, though not the same object.
    point = settled(schedule, schedule.step(schedule.step(point, 5), 2))
    np.testing.assert_allclose(point.P, P, rtol=1e-9)


def test_settling_beforehand_takes_the_same_steps() -> None:
    schedule = fresh()
    steps = settle(schedule)
    point = schedule.first
    for _ in range(steps):
        after = schedule.step(point, 1)
        assert after is not point
        point = after
    assert settled(schedule, point) is point


entries = st.floats(1e-6, 1e4)


@given(st.tuples(entries, st.floats(-0.99, 0.99), entries), st.integers(1, 40), entries, entries)
def test_plain_floats_give_the_bits_of_filterpy(
    P: tuple[float, float, float], periods: int, r_gap: float, r_speed: float
) -> None:
    schedule = GainSchedule(PERIOD_S, ACCELERATION_STD, (r_gap, r_speed))
    a, correlation, d = P
    b = correlation * math.sqrt(a * d)
    point = Covariance(np.array([[a, b], [b, d]]), [[1.0, 0.0], [0.0, 1.0]])
    by_filterpy = schedule._compute(point, periods)
    model = schedule._model
    assert model is not None
    found = _transcribed(point, periods, model)
    assert found.P.tobytes() == by_filterpy.P.tobytes()
    assert (found.K, found.std) == (by_filterpy.K, by_filterpy.std)


def test_a_full_graph_stays_right() -> None:
    """Random histories never meet again, so they make more points than the graph keeps."""
    random = np.random.default_rng(5)
    schedule = fresh()
    point, P = schedule.first, R
    periods = random.integers(1, 4, size=4_600).tolist()
    for number in periods:
        point = schedule.step(point, number)
        P, K = riccati(P, number)
        np.testing.assert_allclose(point.P, P, rtol=1e-9)
        np.testing.assert_allclose(point.K, K, rtol=1e-9)
    last = schedule.step(point, 1)
    assert schedule.step(point, 1) is not last  # full: computed again, to the same numbers
    np.testing.assert_array_equal(schedule.step(point, 1).P, last.P)
    np.testing.assert_allclose(settled(schedule, point).P, settled(fresh(), last).P, rtol=1e-9)
    again = schedule.first  # kept points are still there
    for number in periods[:100]:
        assert schedule.step(again, number) is schedule.step(again, number)
        again = schedule.step(again, number)
