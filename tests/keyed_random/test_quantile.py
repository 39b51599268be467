"""The quantile of the normal distribution agrees with the standard library and with scipy."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtri

from zenvoy.keyed_random.quantile import natural_log, normal_quantile

BINS = 2**53


def quantile(k: int) -> float:
    return float(normal_quantile(np.array(k / BINS)))


@given(st.integers(0, BINS - 1))
def test_every_bin_has_the_quantile_of_its_centre(k: int) -> None:
    if k < BINS // 2:
        # On this side the centre of a bin is a float, or the float nearest to it.
        assert quantile(k) == pytest.approx(NormalDist().inv_cdf((k + 0.5) / BINS), rel=4e-15)
    assert quantile(BINS - 1 - k) == -quantile(k)


@given(st.integers(0, BINS - 1025))
def test_the_quantile_rises(k: int) -> None:
    """Neighbours closer than 1,024 bins may be equal by rounding."""
    assert quantile(k) < quantile(k + 1024)


@pytest.mark.parametrize("size", [0.425 - 1e-12, 0.425 + 1e-12, 0.5 - math.exp(-25.0)])
def test_the_three_parts_meet(size: float) -> None:
    k = int((0.5 - size) * BINS)
    for near in range(max(0, k - 20_000), k + 20_000, 777):
        assert quantile(near) == pytest.approx(float(ndtri((near + 0.5) / BINS)), rel=4e-15)


def test_the_quantile_is_right_at_far_ends() -> None:
    assert quantile(0) == pytest.approx(-8.2923610758, rel=1e-10)
    assert quantile(BINS - 1) == -quantile(0)
    assert 0.0 < quantile(BINS // 2) < 2e-16


@given(st.floats(min_value=1e-300, max_value=1e300))
def test_the_logarithm_agrees_with_the_library(x: float) -> None:
    assert float(natural_log(np.array(x))) == pytest.approx(math.log(x), rel=5e-16, abs=3e-16)
