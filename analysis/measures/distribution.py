"""Empirical distributions of many values, in few points."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_MOST: Final = 1000  # a step is then a thousandth of all


class Steps(NamedTuple):
    """Values in order, and the share of all that are at most as large; both (steps,)."""

    values: Floats
    share: Floats


def steps(values: NDArray[Any]) -> Steps | None:
    """Empirical distribution of values (n,), in a thousand steps at the most; None of none."""
    if not values.size:
        return None
    distinct, counts = np.unique(values, return_counts=True)
    share = np.cumsum(counts) / values.size
    if len(distinct) > _MOST:
        shown = np.unique(np.searchsorted(share, np.arange(1, _MOST + 1) / _MOST - 1e-12))
        distinct, share = distinct[shown], share[shown]
    return Steps(np.asarray(distinct, np.float64), np.asarray(share))
