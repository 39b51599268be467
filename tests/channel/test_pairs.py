"""The search for vehicles in range agrees with a look at every pair."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.channel.pairs import pairs


def brute(
    position: list[float], range_m: float, ring_length_m: float | None
) -> dict[tuple[int, int], tuple[float, bool]]:
    """Return distance, and whether in range, of pairs in range and of neighbours in the row."""
    n, found = len(position), {}
    for i in range(n):
        for j in range(n):
            offset = abs(position[i] - position[j])
            if ring_length_m is not None:
                offset %= ring_length_m
                offset = min(offset, ring_length_m - offset)
            beside = abs(i - j) == 1 or (ring_length_m is not None and abs(i - j) == n - 1)
            if i != j and (offset <= range_m or beside):
                found[i, j] = (offset, offset <= range_m)
    return found


# Quarters of a metre are exact in binary, so both sides agree on a pair just at the range.
quarters = st.integers(-40_000, 40_000).map(lambda k: k / 4)
widths = st.integers(1, 8_000).map(lambda k: k / 4)


@settings(deadline=None, max_examples=300)
@given(
    st.lists(quarters, min_size=2, max_size=25),
    widths,
    st.none() | st.integers(40, 8_000).map(lambda k: k / 4),
)
def test_agrees_with_brute_force(
    position: list[float], range_m: float, ring_length_m: float | None
) -> None:
    """Ranges are below and above half of the ring. Vehicles may share a place."""
    found = pairs(np.array(position), range_m, ring_length_m)
    rows = list(zip(found.source.tolist(), found.destination.tolist(), strict=True))
    values = zip(found.distance.tolist(), found.in_range.tolist(), strict=True)
    expected = brute(position, range_m, ring_length_m)
    if ring_length_m is not None and 2 * range_m >= ring_length_m:
        assert all(within for _, within in expected.values())
    assert rows == sorted(rows)
    assert dict(zip(rows, values, strict=True)) == expected


def test_a_ring_of_forty_by_hand() -> None:
    """At 37.5 m apart and 100 m of range there are two on each side, 37.5 and 75 m away."""
    found = pairs(np.arange(39, -1, -1.0) * 37.5, 100.0, 1_500.0)
    assert len(found.source) == 40 * 4
    assert found.destination[found.source == 0].tolist() == [1, 2, 38, 39]
    assert found.distance[found.source == 0].tolist() == [37.5, 75.0, 75.0, 37.5]
    assert found.in_range.all()


def test_of_vehicles_out_of_range_only_neighbours_have_a_row() -> None:
    found = pairs(np.array([1_000.0, 500.0, 490.0, 0.0]), 50.0, None)
    rows = zip(found.source.tolist(), found.destination.tolist(), strict=True)
    assert list(zip(rows, found.in_range.tolist(), strict=True)) == [
        ((0, 1), False),
        ((1, 0), False),
        ((1, 2), True),
        ((2, 1), True),
        ((2, 3), False),
        ((3, 2), False),
    ]
