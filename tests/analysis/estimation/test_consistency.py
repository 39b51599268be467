"""Measures of consistency agree with scipy, and tell right filters from overconfident ones."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from zenvoy.analysis.measures.consistency import (
    consistency,
    interval,
    normalised_error,
    normalised_innovation,
    spread,
)


def test_the_interval_is_that_of_the_chi_squared_distribution() -> None:
    low, high = interval(np.array([1, 2, 40, 1000]))
    for m, a, b in zip((1, 2, 40, 1000), low, high, strict=True):
        np.testing.assert_allclose((a, b), stats.chi2(m).ppf([0.025, 0.975]) / m)


def test_spread_by_hand() -> None:
    error = np.array([0.5, -1.5, 2.5, -3.5, np.nan, 1.0])
    assert spread(error, np.array([1.0] * 4 + [1.0, np.nan])) == (0.25, 0.5, 0.75)
    assert spread(np.array([np.nan]), np.array([1.0])) is None


def simulate(
    *, runs: int, steps: int, process: float, reading: float, claimed: float = 1.0
) -> tuple[KalmanFilter, list[NDArray[Any]]]:
    """Run constant-velocity filters of filterpy on simulated gaps.

    `claimed` is the Q of the filters as a multiple of the true Q. Return true states, readings,
    estimates (steps, runs, 2), covariances (steps, 2, 2), and innovations with their covariances.
    """
    rng = np.random.default_rng(7)
    f, b = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([0.005, 0.1])
    r = np.diag([reading**2, (0.5 * reading) ** 2])
    truth = rng.multivariate_normal([37.5, 0.0], r, size=runs)
    filters = []
    for _ in range(runs):
        kalman = KalmanFilter(dim_x=2, dim_z=2)
        kalman.F, kalman.H, kalman.R, kalman.P = f, np.eye(2), r, r.copy()
        kalman.Q = claimed * process**2 * np.outer(b, b)
        kalman.x = np.array([37.5, 0.0])
        filters.append(kalman)
    columns: list[list[Any]] = [[] for _ in range(6)]
    for _ in range(steps):
        truth = truth @ f.T + rng.normal(0.0, process, size=(runs, 1)) * b
        z = truth + rng.multivariate_normal([0.0, 0.0], r, size=runs)
        for kalman, reading_of in zip(filters, z, strict=True):
            kalman.predict()
            kalman.update(reading_of)
        row = (
            truth,
            z,
            np.array([kalman.x for kalman in filters]),
            filters[0].P,
            np.array([kalman.y for kalman in filters]),
            filters[0].S,
        )
        for column, value in zip(columns, row, strict=True):
            column.append(value)
    return filters[0], [np.array(column) for column in columns]


def test_the_innovation_follows_from_the_residual() -> None:
    """νᵀ S⁻¹ ν of the prediction equals (z - x̂)ᵀ (R - P)⁻¹ (z - x̂) of the logged values."""
    kalman, (_, z, x, p, y, s) = simulate(runs=3, steps=50, process=0.5, reading=2.0)
    left = np.einsum("tri,tij,trj->tr", y, np.linalg.inv(s), y)
    residual = z - x
    right = np.einsum("tri,tij,trj->tr", residual, np.linalg.inv(kalman.R - p), residual)
    np.testing.assert_allclose(left, right, rtol=1e-6)


@given(st.floats(0.1, 10), st.floats(0.05, 10), st.floats(-20, 20), st.floats(-20, 20))
def test_the_innovation_of_a_scalar_is_exact(p: float, r: float, x: float, z: float) -> None:
    after = p * r / (p + r)
    estimate = x + p / (p + r) * (z - x)
    args = [np.array([value]) for value in (z, estimate, np.sqrt(after), r)]
    found = normalised_innovation(*args)
    if after > r / 2 * (1 + 1e-9):
        assert np.isnan(found[0])
    elif after < r / 2 * (1 - 1e-9):
        assert found[0] == pytest.approx((z - x) ** 2 / (p + r), rel=1e-6, abs=1e-9)


def test_a_filter_with_the_right_covariance_is_consistent() -> None:
    kalman, (truth, z, x, p, _, _) = simulate(runs=30, steps=800, process=0.5, reading=2.0)
    for of in (0, 1):
        std = np.sqrt(p[:, of, of])[:, None] * np.ones((1, 30))
        variance = np.full_like(std, kalman.R[of, of])
        error = x[:, :, of] - truth[:, :, of]
        nis = consistency(normalised_innovation(z[:, :, of], x[:, :, of], std, variance))
        nees = consistency(normalised_error(error, std))
        within = spread(error, std)
        assert nis is not None
        assert nees is not None
        assert within is not None
        # 800 independent cycles have 95 ± 0.8 %. Errors are correlated and scatter more.
        assert nis.share_inside == pytest.approx(0.95, abs=0.025)
        assert nis.mean == pytest.approx(1.0, abs=0.05)
        assert nees.share_inside == pytest.approx(0.95, abs=0.06)
        assert nees.mean == pytest.approx(1.0, abs=0.15)
        np.testing.assert_allclose(within, (0.683, 0.954, 0.997), atol=0.04)


def test_an_overconfident_filter_is_detected() -> None:
    kalman, (truth, z, x, p, _, _) = simulate(
        runs=30, steps=300, process=2.0, reading=2.0, claimed=0.01
    )
    std = np.sqrt(p[:, 0, 0])[:, None] * np.ones((1, 30))
    nees = consistency(normalised_error(x[:, :, 0] - truth[:, :, 0], std)[100:])
    assert nees is not None
    assert nees.mean > 2.0
    assert nees.share_inside < 0.1
    variance = np.full_like(std, kalman.R[0, 0])
    nis = consistency(normalised_innovation(z[:, :, 0], x[:, :, 0], std, variance))
    assert nis is not None
    assert nis.mean > 1.1


def test_consistency_leaves_out_unknown_values() -> None:
    nan = np.nan
    found = consistency(np.array([[1.0, nan, 3.0], [nan, nan, nan], [0.0, 0.0, 0.0]]))
    assert found is not None
    np.testing.assert_array_equal(found.per_cycle, [2.0, nan, 0.0])
    low, high = interval(np.array([2, 3]))
    np.testing.assert_array_equal(found.low, [low[0], nan, low[1]])
    np.testing.assert_array_equal(found.high, [high[0], nan, high[1]])
    assert found.mean == pytest.approx(4.0 / 5.0)
    assert found.share_inside == 0.5
    assert consistency(np.full((2, 2), nan)) is None
