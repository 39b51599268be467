"""The relative motion of two vehicles, and the motion that a vehicle reports."""

from __future__ import annotations

from typing import Any, NamedTuple

Number = Any
"""A float, or an array of floats (seeds, vehicles); a law accepts both."""


class Relative(NamedTuple):
    """The gap p = p_(i,i-1) = p_{i-1} - p_i > 0 (m) and its rate of change v (m/s; paper Eq. 3)."""

    p: Number
    v: Number


class Motion(NamedTuple):
    """Speed (m/s) and acceleration (m/s²) of another vehicle, as its beacon reports them."""

    v: Number
    a: Number
