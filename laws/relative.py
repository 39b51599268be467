"""The relative motion of two vehicles, and the motion that a vehicle reports."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

NAN: Final = float("nan")

Number = Any
"""A float, or an array of floats (seeds, vehicles); a law accepts both."""


class Relative(NamedTuple):
    """The gap p = p_(i,i-1) = p_{i-1} - p_i > 0 (m) and its rate of change v (m/s; paper Eq. 3)."""

    p: Number
    v: Number


class Motion(NamedTuple):
    """The motion that another vehicle reports in its newest beacon.

    v, a: its speed (m/s) and acceleration (m/s²). distance: its position minus the own position at
    the start of the cycle, m. age_s: age of its readings at the start of the cycle, s. command: its
    newest command, m/s²; NaN unless the law needs commands. steps: number of links from there to
    the host, 1 for the vehicle ahead.
    """

    v: Number
    a: Number
    distance: Number = NAN
    age_s: Number = NAN
    command: Number = NAN
    steps: Number = NAN
