"""Bounds for the offset of another machine's clock, from round trips to it.

A message that leaves at t0 of the own clock arrives when the other clock shows T, and the answer is
back at t1. The delays are unknown, but not negative. So the offset of the other clock is at most
T - t0 and at least T - t1: half the round trip to either side of their middle (Cristian 1989; RFC
5905, section 8). Between round trips the bounds widen as fast as two clocks may drift apart. The
tightest ones of all round trips count, each side by itself, as in Marzullo's intersection.
"""

from __future__ import annotations

from typing import Final, NamedTuple

MAX_DRIFT_PPM: Final = 1_000
"""How fast two clocks may drift apart: each by the 500 ppm to which Linux and NTP limit a clock."""

_MILLION: Final = 1_000_000


class Offset(NamedTuple):
    """How far another clock is ahead of the own one, ns, and by how much this may be wrong, ns."""

    ns: int
    error_ns: int


class Drift(NamedTuple):
    """The least and the greatest rate at which a clock may gain on another, ppm."""

    least_ppm: float
    most_ppm: float


class ClockBounds:
    """The bounds of all round trips so far. All of them grow at one rate, so one number suffices.

    The offset at the own time t is at most (upper + rate · t) and at least (lower - rate · t), in
    millionths of a ns.
    """

    def __init__(self, max_drift_ppm: int = MAX_DRIFT_PPM) -> None:
        self._rate = max_drift_ppm
        self._upper: int | None = None
        self._lower = 0

    def add(self, sent_ns: int, other_ns: int, back_ns: int) -> None:
        """Take in a round trip: the own times of question and answer, the other clock between."""
        # The other clock was read at sent_ns or later: the bounds cannot have drifted for longer.
        upper = (other_ns - sent_ns) * _MILLION - self._rate * sent_ns
        lower = (other_ns - back_ns) * _MILLION + self._rate * sent_ns
        if self._upper is not None:
            upper, lower = min(upper, self._upper), max(lower, self._lower)
            if lower - self._rate * back_ns > upper + self._rate * back_ns:
                # No clock drifts like that: one of the machines has slept. Earlier bounds are void.
                self._upper = None
                self.add(sent_ns, other_ns, back_ns)
                return
        self._upper, self._lower = upper, lower

    def at(self, now_ns: int) -> Offset | None:
        """Return the offset at a time of the own clock, after the last round trip; None before."""
        if self._upper is None:
            return None
        most_ns = -(-(self._upper + self._rate * now_ns) // _MILLION)
        least_ns = (self._lower - self._rate * now_ns) // _MILLION
        middle_ns = (most_ns + least_ns) // 2
        return Offset(middle_ns, most_ns - middle_ns)


def mean_drift(first: Offset, last: Offset, between_ns: int) -> Drift:
    """Return by how much the own clock gained on the other between two times, on average."""
    gained_ns = first.ns - last.ns
    error_ns = first.error_ns + last.error_ns
    ends = (gained_ns - error_ns, gained_ns + error_ns)
    least, most = (end_ns / between_ns * _MILLION for end_ns in ends)
    return Drift(least, most)
