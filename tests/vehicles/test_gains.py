"""The graph of covariances: shared, settled, and right when it is not kept any more."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from zenvoy.vehicles.estimator import Filter
from zenvoy.vehicles.gains import Covariance, GainSchedule, gain_schedule, settle

Floats = NDArray[np.float64]

PERIOD_S, ACCELERATION_STD = 0.1, 0.5
VARIANCES = (4.6875, 3.0)
F = np.array([[1.0, PERIOD_S], [0.0, 1.0]])
B = np.array([[PERIOD_S**2 / 2], [PERIOD_S]])
Q = ACCELERATION_STD**2 * B @ B.T
R = np.diag(VARIANCES)


@pytest.fixture(autouse=True)
def _unused_graphs() -> None:
    """Tests of other modules may have filled the graph of this model, which then keeps no more."""
    gain_schedule.cache_clear()


def riccati(before: Floats, periods: int) -> tuple[Floats, Floats]:
    """P and K after `periods` predictions and an update, straight from the textbook."""
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
    variances = (2.5, 1.25)  # of no other test: a graph keeps so many points and no more
    first, second = Filter(PERIOD_S, ACCELERATION_STD), Filter(PERIOD_S, ACCELERATION_STD)
    for k in range(20):
        inputs = (0.5,) * (1 + k % 3)
        first.step(inputs, (37.5, 0.0 + k), variances)
        second.step(inputs, (30.0, 1.0 - k), variances)
        assert first.P is second.P
    assert first.x != second.x


def test_only_the_same_model_is_shared() -> None:
    shared = gain_schedule(PERIOD_S, ACCELERATION_STD, VARIANCES)
    assert gain_schedule(PERIOD_S, ACCELERATION_STD, VARIANCES) is shared
    for other in ((0.2, 0.5, VARIANCES), (0.1, 0.6, VARIANCES), (0.1, 0.5, (3.0, 4.6875))):
        assert gain_schedule(*other) is not shared


def test_starts_with_the_covariance_of_a_reading() -> None:
    np.testing.assert_array_equal(fresh().first.P, R)
    assert fresh().first.std == pytest.approx(np.sqrt(VARIANCES), rel=1e-15)


def test_settles_into_a_point_that_leads_to_itself() -> None:
    schedule = fresh()
    point = settled(schedule, schedule.first)
    P, K = riccati(point.P, 1)  # noqa: N806  # the letters of the field
    np.testing.assert_allclose(P, point.P, rtol=1e-11)
    np.testing.assert_allclose(K, point.K, rtol=1e-11)
    # From any history the same point is reached, in number if not as an object.
    point = settled(schedule, schedule.step(schedule.step(point, 5), 2))
    np.testing.assert_allclose(point.P, P, rtol=1e-9)


def test_settling_beforehand_walks_the_same_way() -> None:
    schedule = fresh()
    steps = settle(schedule)
    point = schedule.first
    for _ in range(steps):
        after = schedule.step(point, 1)
        assert after is not point
        point = after
    assert settled(schedule, point) is point


def test_stays_right_when_it_is_full() -> None:
    """Random histories never meet again: more of them than are kept."""
    random = np.random.default_rng(5)
    schedule = fresh()
    point, P = schedule.first, R  # noqa: N806  # the letters of the field
    periods = random.integers(1, 4, size=4_600).tolist()
    for number in periods:
        point = schedule.step(point, number)
        P, K = riccati(P, number)  # noqa: N806
        np.testing.assert_allclose(point.P, P, rtol=1e-9)
        np.testing.assert_allclose(point.K, K, rtol=1e-9)
    last = schedule.step(point, 1)
    assert schedule.step(point, 1) is not last  # full: computed anew, to the same numbers
    np.testing.assert_array_equal(schedule.step(point, 1).P, last.P)
    np.testing.assert_allclose(settled(schedule, point).P, settled(fresh(), last).P, rtol=1e-9)
    again = schedule.first  # what was kept is still there
    for number in periods[:100]:
        assert schedule.step(again, number) is schedule.step(again, number)
        again = schedule.step(again, number)
