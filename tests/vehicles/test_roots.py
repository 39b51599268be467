"""The root of a covariance is that of Cholesky, and exists for a singular one."""

from __future__ import annotations

import numpy as np
import pytest
from filterpy.kalman.sigma_points import cholesky  # scipy's, the default there
from hypothesis import example, given
from hypothesis import strategies as st

from zenvoy.vehicles.nonlinear import upper_root


@given(st.floats(0.01, 1e3), st.floats(0.01, 1e3), st.floats(-0.999, 0.999))
@example(1.0, 1.0, 0.0)
def test_the_root_equals_that_of_cholesky(first: float, second: float, correlation: float) -> None:
    shared = correlation * first * second
    covariance = np.array([[first**2, shared], [shared, second**2]])
    root = upper_root(covariance)
    np.testing.assert_allclose(root, cholesky(covariance), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(root.T @ root, covariance, rtol=1e-12, atol=1e-12)
    assert upper_root(covariance[:1, :1]).tolist() == [[pytest.approx(first, rel=1e-15)]]


def test_a_singular_matrix_has_a_root() -> None:
    random = np.random.default_rng(9)
    for exponent in range(-9, 19):
        for direction in random.uniform(-1.0, 1.0, (20, 2, 1)):
            singular = 10.0**exponent * direction @ direction.T
            root = upper_root(singular)
            np.testing.assert_allclose(root.T @ root, singular, rtol=1e-12)
