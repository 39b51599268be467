"""The muster of a run knows who is missing, and on which machine each process runs."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.muster import Muster, spans
from zenvoy.fleet.progress import Arrival


@given(st.sets(st.integers(1, 40)))
def test_spans_hold_the_same_numbers(vehicles: set[int]) -> None:
    found: set[int] = set()
    for span in filter(None, spans(vehicles).split(", ")):
        first, _, last = span.partition("-")
        found |= set(range(int(first), int(last or first) + 1))
    assert found == vehicles


def test_spans_are_short() -> None:
    assert spans([1, 2, 3, 7, 9, 10]) == "1-3, 7, 9-10"


def test_who_comes_is_no_longer_missing() -> None:
    muster = Muster(vehicle_processes(6, 2))
    assert muster.missing == [1, 2, 3, 4, 5, 6]
    assert muster.note(Arrival("vehicles-03-04", "", True))
    assert not muster.note(Arrival("vehicles-03-04", "beta", True))
    assert not muster.note(Arrival("channel", "", True))
    assert muster.missing == [1, 2, 5, 6]
    assert muster.host_of("vehicles-03-04 and 2 more") == "beta"
    assert muster.host_of("vehicles-01-02") == ""
    assert muster.note(Arrival("vehicles-03-04", "", False))
    assert muster.missing == [1, 2, 3, 4, 5, 6]
