"""Reduces the empirical distribution of many values to a few points."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_MAX_STEPS: Final = 1000


class Steps(NamedTuple):
    """Values in ascending order, and the share of all values up to each; both (steps,)."""

    values: Floats
    share: Floats


def steps(values: NDArray[Any]) -> Steps | None:
    """Return the distribution of values (n,) in at most 1000 steps; None if there are none."""
    if not values.size:
        return None
    distinct, counts = np.unique(values, return_counts=True)
    share = np.cumsum(counts) / values.size
    if len(distinct) > _MAX_STEPS:
        levels = np.arange(1, _MAX_STEPS + 1) / _MAX_STEPS
        shown = np.unique(np.searchsorted(share, levels - 1e-12))
        distinct, share = distinct[shown], share[shown]
    return Steps(np.asarray(distinct, np.float64), np.asarray(share))
