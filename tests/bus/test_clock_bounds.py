"""The true offset of a clock lies within its bounds, whatever the delays and the drift."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus.clock_bounds import (
    MAX_DRIFT_PPM,
    ClockBounds,
    Drift,
    Offset,
    mean_drift,
)

MS = 1_000_000
HOUR = 3_600_000 * MS

delays = st.one_of(st.integers(0, 2 * MS), st.integers(0, 5_000 * MS))
rates = st.integers(-MAX_DRIFT_PPM, MAX_DRIFT_PPM)
trips = st.tuples(delays, delays, delays, rates, rates)


class Clocks:
    """Two clocks, of which the other one drifts as it is told to."""

    def __init__(self, own_ns: int, other_ns: int) -> None:
        self.own_ns, self.other_ns = own_ns, Fraction(other_ns)

    def pass_by(self, own_ns: int, rate_ppm: int) -> None:
        """Let time pass."""
        self.own_ns += own_ns
        self.other_ns += own_ns + Fraction(own_ns * rate_ppm, 1_000_000)

    @property
    def offset_ns(self) -> Fraction:
        """The true offset of the other clock."""
        return self.other_ns - self.own_ns


@given(
    st.integers(0, 100 * HOUR), st.integers(0, 100 * HOUR), st.lists(trips, min_size=1, max_size=20)
)
def test_the_true_offset_is_within_the_bounds_at_any_time(
    own_ns: int, other_ns: int, trips: list[tuple[int, int, int, int, int]]
) -> None:
    clocks, bounds = Clocks(own_ns, other_ns), ClockBounds()
    for there_ns, back_ns, pause_ns, rate, later_rate in trips:
        sent_ns = clocks.own_ns
        clocks.pass_by(there_ns, rate)
        read_ns = int(clocks.other_ns)  # a clock shows whole ns
        clocks.pass_by(back_ns, later_rate)
        bounds.add(sent_ns, read_ns, clocks.own_ns)
        for after_ns in (0, pause_ns):
            clocks.pass_by(after_ns, rate)
            found = bounds.at(clocks.own_ns)
            assert found is not None
            assert abs(found.ns - clocks.offset_ns) <= found.error_ns + 1


def test_one_round_trip_says_as_much_as_half_of_it() -> None:
    bounds = ClockBounds(0)
    assert bounds.at(0) is None
    bounds.add(1_000, 51_500, 2_000)
    assert bounds.at(2_000) == bounds.at(10 * HOUR) == Offset(50_000, 500)


def test_the_tightest_bounds_of_several_round_trips_count_each_side_by_itself() -> None:
    bounds = ClockBounds(0)
    bounds.add(0, 50_100, 9_000)  # there quickly, back slowly
    bounds.add(10_000, 69_000, 19_100)  # and the other way round
    assert bounds.at(20_000) == Offset(50_000, 100)


def test_bounds_widen_until_the_next_round_trip() -> None:
    bounds = ClockBounds(1_000)
    bounds.add(0, 7_000, 0)
    assert bounds.at(1_000 * MS) == Offset(7_000, MS)
    bounds.add(1_000 * MS, 1_000 * MS + 7_000, 1_000 * MS)
    assert bounds.at(1_000 * MS) == Offset(7_000, 0)


def test_a_machine_that_has_slept_is_measured_anew() -> None:
    bounds = ClockBounds()
    bounds.add(0, 5_000, 1_000)
    bounds.add(2_000, HOUR + 2_500, 3_000)
    assert bounds.at(3_000) == Offset(HOUR, 501)


def test_drift_lies_between_what_both_offsets_allow() -> None:
    first, last = Offset(5 * MS, MS), Offset(4 * MS, 2 * MS)
    assert mean_drift(first, last, 1_000 * MS) == Drift(-2_000.0, 4_000.0)
