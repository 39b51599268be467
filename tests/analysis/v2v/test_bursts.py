"""Bursts of losses agree with a plain count, and their law with scipy."""

from __future__ import annotations

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from tests.analysis.v2v.frames import DELIVERED, LOST, table_of, tables
from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.measures.links import geometric, loss_bursts


def naive_bursts(frames: Table) -> dict[int, int]:
    """Return the lengths of runs of losses, link by link, and their counts."""
    lengths: dict[int, int] = {}
    rows = zip(
        *(frames[name].tolist() for name in ("source", "destination", "outcome")), strict=True
    )
    links: dict[tuple[int, int], list[bool]] = {}
    for source, destination, outcome in rows:
        links.setdefault((source, destination), []).append(outcome == LOST)
    for fates in links.values():
        for lost, group in groupby(fates):
            if lost:
                length = len(list(group))
                lengths[length] = lengths.get(length, 0) + 1
    return lengths


@given(tables())
def test_bursts_agree_with_a_plain_count(frames: Table) -> None:
    found = loss_bursts(frames, 3)
    assert {length: number for length, number in enumerate(found) if number} == naive_bursts(frames)


def test_missing_numbers_end_a_burst() -> None:
    frames = table_of([LOST] * 5, sequence=np.array([0, 1, 3, 4, 5], np.uint32))
    np.testing.assert_array_equal(loss_bursts(frames, 2), [0, 0, 1, 1])
    np.testing.assert_array_equal(loss_bursts(table_of([DELIVERED]), 2), [0])


def test_bursts_at_the_largest_numbers_are_distinguished() -> None:
    last = 2**32 - 1
    frames = table_of(
        [LOST, LOST],
        source=np.array([1, 1], np.uint16),
        destination=np.array([2, 3], np.uint16),
        sequence=np.array([last, 0], np.uint32),
    )
    np.testing.assert_array_equal(loss_bursts(frames, 10_000), [0, 2])


@given(st.floats(0.0, 0.9))
def test_the_geometric_law_agrees_with_scipy(p: float) -> None:
    share = geometric(p, 2_000)
    assert share[0] == 0.0
    assert share.sum() == pytest.approx(1.0)
    assert (share * np.arange(2_001)).sum() == pytest.approx(1.0 / (1.0 - p))
    np.testing.assert_allclose(share[1:20], stats.geom(1.0 - p).pmf(np.arange(1, 20)), atol=1e-15)
