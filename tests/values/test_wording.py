"""Messages give numbers in a short form."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from zenvoy.values.wording import spans


@given(st.sets(st.integers(1, 40)))
def test_spans_hold_the_same_numbers(vehicles: set[int]) -> None:
    found: set[int] = set()
    for span in filter(None, spans(vehicles).split(", ")):
        first, _, last = span.partition("-")
        found |= set(range(int(first), int(last or first) + 1))
    assert found == vehicles


def test_spans_are_short() -> None:
    assert spans([1, 2, 3, 7, 9, 10]) == "1-3, 7, 9-10"


def test_vehicles_are_named_as_in_a_scenario() -> None:
    assert [spans(v) for v in ([3], [2, 3, 4], [1, 3, 4, 9])] == ["3", "2-4", "1, 3-4, 9"]
