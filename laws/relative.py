"""How vehicles move relative to each other, and what they say of themselves."""

from __future__ import annotations

from typing import Any, NamedTuple

Number = Any
"""A float, or an array of floats (seeds, vehicles): a law serves both."""


class Relative(NamedTuple):
    """p = p_(i,i-1) = p_{i-1} - p_i > 0 in m; v its rate of change in m/s (paper Eq. 3)."""

    p: Number
    v: Number


class Motion(NamedTuple):
    """Speed (m/s) and acceleration (m/s²) of another vehicle, as its beacon reports them."""

    v: Number
    a: Number
