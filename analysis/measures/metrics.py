"""Figures of merit as functions of arrays. Axis 0 is time, axis 1 is the vehicle."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Accuracy(NamedTuple):
    """How well values agree with the truth: RMSE in their unit, R² = 1 - SS_res / SS_tot.

    `spread` is the standard deviation of the truth. Where the RMSE exceeds it, R² is below 0 and
    has no further meaning. This happens in steady motion, which hardly varies.
    """

    rmse: float
    r2: float
    spread: float


def smallest_gaps(gap: Floats) -> Floats:
    """Return the three smallest gaps at each time (T, 3), m, or all if there are fewer."""
    gap = gap[:, ~np.isnan(gap).any(axis=0)]
    k = min(3, gap.shape[1])
    return np.asarray(np.partition(gap, k - 1, axis=1)[:, :k])


def largest_gaps(gap: Floats) -> Floats:
    """Return the three largest gaps at each time (T, 3), m, or all if there are fewer."""
    return -smallest_gaps(-gap)


def min_distance(gap: Floats) -> Floats:
    """Return MinDistance (T,), m: the mean of the three smallest gaps (paper Section IV)."""
    return np.asarray(smallest_gaps(gap).mean(axis=1))


def max_distance(gap: Floats) -> Floats:
    """Return MaxDistance (T,), m: the mean of the three largest gaps (paper Section IV)."""
    return np.asarray(largest_gaps(gap).mean(axis=1))


def accuracy(values: NDArray[Any], truth: NDArray[Any]) -> Accuracy | None:
    """Compare values with the truth wherever both are known; None where there is no such pair."""
    known = ~(np.isnan(values) | np.isnan(truth))
    if not known.any():
        return None
    error, true = values[known] - truth[known], truth[known]
    total = float(((true - true.mean()) ** 2).sum())
    residual = float((error**2).sum())
    return Accuracy(
        rmse=float(np.sqrt(residual / error.size)),
        r2=1.0 - residual / total if total > 0.0 else float("nan"),
        spread=float(np.sqrt(total / error.size)),
    )


def meaningful_r2(r2: float) -> float | None:
    """Return R² where it has a meaning: None below 0, and where the truth does not vary at all."""
    return r2 if r2 >= 0.0 else None
