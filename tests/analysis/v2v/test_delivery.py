"""Delivery, distances and latencies agree with scipy, numpy, and counts by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tests.analysis.v2v.frames import DELIVERED, LATE, LOST, OUT, table_of
from zenvoy.analysis.measures.links import Delivery, by_distance, delivery, latencies, wilson


@given(st.integers(0, 10_000), st.integers(1, 10_000))
def test_wilson_agrees_with_scipy(successes: int, trials: int) -> None:
    successes = min(successes, trials)
    low, high = wilson(np.array([successes]), np.array([trials]))
    expected = stats.binomtest(successes, trials).proportion_ci(method="wilson")
    np.testing.assert_allclose((low[0], high[0]), (expected.low, expected.high), atol=1e-12)


def test_wilson_intervals_at_the_ends() -> None:
    low, high = wilson(np.array([0, 0, 7]), np.array([0, 7, 7]))
    assert (low[0], high[0]) == (0.0, 1.0)  # there are no trials
    assert low[1] == 0.0 < high[1] < 0.5
    assert 0.5 < low[2] < high[2] == 1.0


def test_delivery_by_hand() -> None:
    outcomes = delivery(table_of([DELIVERED, LATE, LOST, OUT, DELIVERED, LOST]))
    assert outcomes == Delivery(sent=5, delivered=3, late=1, lost=2)


def test_distances_by_hand() -> None:
    outcomes = [DELIVERED, LOST, LATE, DELIVERED, OUT]
    distance = np.array([0.0, 9.0, 11.0, 95.0, 2_000.0], np.float32)
    found = by_distance(table_of(outcomes, distance=distance), bins=10)
    np.testing.assert_array_equal(found.edges_m, np.arange(11) * 10.0)
    np.testing.assert_array_equal(found.sent, [2, 1, 0, 0, 0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(found.delivered, [1, 1, 0, 0, 0, 0, 0, 0, 0, 1])


@given(
    st.lists(
        st.tuples(st.floats(0, 60_000, width=32), st.sampled_from([DELIVERED, LATE, LOST, OUT])),
        min_size=1,
        max_size=50,
    ),
    st.integers(1, 30),
)
def test_each_frame_is_in_one_bin(rows: list[tuple[float, int]], bins: int) -> None:
    frames = table_of(
        [outcome for _, outcome in rows],
        distance=np.array([distance for distance, _ in rows], np.float32),
    )
    found, outcomes = by_distance(frames, bins), delivery(frames)
    assert found.sent.sum() == outcomes.sent
    assert found.delivered.sum() == outcomes.delivered
    assert len(found.sent) == len(found.edges_m) - 1 <= bins + 1
    for at, (low, high) in enumerate(zip(found.edges_m, found.edges_m[1:], strict=False)):
        width = high - low
        inside = [o for d, o in rows if low + 1e-4 * width <= d < high - 1e-4 * width]
        assert found.sent[at] >= sum(outcome != OUT for outcome in inside)


@given(st.lists(st.integers(-1, 500_000_000), min_size=1, max_size=60))
def test_latencies_agree_with_numpy(latency_ns: list[int]) -> None:
    outcomes = [LOST if latency < 0 else DELIVERED for latency in latency_ns]
    found = latencies(table_of(outcomes, latency_ns=np.array(latency_ns)))
    known = np.array([latency for latency in latency_ns if latency >= 0])
    if not known.size:
        assert found is None
        return
    assert found is not None
    assert found.counts.sum() == len(known)
    assert found.mean_ms == pytest.approx(known.mean() * 1e-6)
    for share in (0.01, 0.5, 0.95, 1.0):
        expected = np.quantile(known, share, method="inverted_cdf")
        below = expected * 1e-6 - found.quantile_ms(share)
        assert -1e-9 < below < found.width_ns * 1e-6 + 1e-9
