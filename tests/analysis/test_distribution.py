"""A distribution is drawn as steps: the cumulative share of its values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.analysis.measures.distribution import steps


@given(st.lists(st.integers(min_value=-5, max_value=5), min_size=1))
def test_steps_are_the_cumulative_shares(values: list[int]) -> None:
    found = steps(np.array(values))
    assert found is not None
    for value, share in zip(*found, strict=True):
        assert share == pytest.approx(sum(v <= value for v in values) / len(values))
    assert found.share[-1] == 1.0
    assert list(found.values) == sorted(set(values))


def test_steps_of_many_values_are_few_and_correct() -> None:
    values = np.random.default_rng(1).exponential(size=50_000)
    found = steps(values)
    assert found is not None
    assert len(found.values) <= 1000
    exact = np.searchsorted(np.sort(values), found.values, side="right") / values.size
    assert found.share == pytest.approx(exact)
    assert np.diff(found.share).max() < 0.0011
    assert found.share[-1] == 1.0
    assert steps(np.zeros(0)) is None
