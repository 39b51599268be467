"""The relative state of two vehicles that follow each other."""

from __future__ import annotations

from typing import NamedTuple


class Relative(NamedTuple):
    """p = p_(i,i-1) = p_{i-1} - p_i > 0 in m; v its rate of change in m/s (paper Eq. 3)."""

    p: float
    v: float
