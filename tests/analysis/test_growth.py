"""The growth of the swing from vehicle to vehicle, and its median with an interval."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from zenvoy.analysis.measures.growth import growth_per_vehicle, growths, median_of


def test_the_growth_of_sines_is_that_of_their_amplitudes() -> None:
    time_s = np.arange(0.0, 100.0, 0.1)
    sine = np.sin(2.0 * np.pi * 0.1 * time_s)
    speed = 15.0 + sine[:, None] * np.array([1.0, 1.5, 3.0, 2.7])
    assert growths(speed) == pytest.approx([1.5, 2.0, 0.9])
    assert growth_per_vehicle(speed) == pytest.approx(2.7 ** (1.0 / 3.0))


@pytest.mark.parametrize(("n", "rank"), [(6, 1), (9, 2), (20, 6), (100, 40)])
def test_the_interval_of_a_median_is_the_tightest_of_95_percent(n: int, rank: int) -> None:
    """The ranks are those of published tables of the sign test."""
    values = np.random.default_rng(1).permutation(np.arange(1.0, n + 1.0))
    found = median_of(values)
    assert (found.low, found.high, found.n) == (rank, n + 1 - rank, n)
    assert found.median == (n + 1) / 2.0
    assert 1.0 - 2.0 * binom.cdf(rank - 1, n, 0.5) >= 0.95
    assert 1.0 - 2.0 * binom.cdf(rank, n, 0.5) < 0.95


def test_few_values_have_no_interval() -> None:
    assert np.isnan(median_of([1.0, 2.0, 3.0, 4.0, 5.0]).low)
    assert median_of([2.0]).median == 2.0


def test_the_interval_covers_the_median_as_often_as_it_says() -> None:
    rng = np.random.default_rng(7)
    covered = [
        found.low <= 0.0 <= found.high
        for found in (median_of(rng.standard_t(2, size=24)) for _ in range(2000))
    ]
    assert 0.94 < np.mean(covered) < 0.99
