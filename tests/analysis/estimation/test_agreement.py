"""Agreement with the truth equals figures by hand and those of scipy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from zenvoy.analysis.measures.agreement import agreement


def test_agreement_by_hand() -> None:
    found = agreement(np.array([2.0, 4.0, 6.0, np.nan]), np.array([1.0, 2.0, 3.0, 4.0]))
    assert found is not None
    assert found.rmse == pytest.approx(np.sqrt(14.0 / 3.0))  # errors 1, 2, 3
    assert found.r2 == pytest.approx(1.0 - 14.0 / 2.0)  # SS_tot of 1, 2, 3
    assert found.r2_correlation == pytest.approx(1.0)  # twice the truth
    assert found.samples == 3


def test_agreement_of_no_values_is_unknown() -> None:
    assert agreement(np.array([np.nan]), np.array([1.0])) is None


def test_agreement_if_the_values_or_the_truth_do_not_vary() -> None:
    found = agreement(np.array([3.0, 3.0]), np.array([1.0, 2.0]))
    assert found is not None
    assert np.isnan(found.r2_correlation)
    found = agreement(np.array([1.0, 2.0]), np.array([3.0, 3.0]))
    assert found is not None
    assert np.isnan(found.r2)
    assert np.isnan(found.r2_correlation)


@given(st.lists(st.tuples(st.integers(-99, 99), st.integers(-99, 99)), min_size=3, max_size=30))
def test_agreement_agrees_with_scipy(pairs: list[tuple[int, int]]) -> None:
    values, truth = np.array(pairs, float).T
    found = agreement(values, truth)
    assert found is not None
    if np.ptp(values) and np.ptp(truth):
        expected = stats.pearsonr(values, truth).statistic ** 2
        assert found.r2_correlation == pytest.approx(expected, abs=1e-9)
    # The best line through the points is at least as good as the values themselves.
    if np.ptp(truth) and np.ptp(values):
        assert found.r2 <= found.r2_correlation + 1e-9
