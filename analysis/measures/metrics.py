"""Figures of merit, as functions of arrays. Axis 0 is time, axis 1 the vehicle."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Fit(NamedTuple):
    """How well values agree with the truth: RMSE in their unit, R² = 1 - SS_res / SS_tot.

    `spread` is the standard deviation of the truth. Where it is less than the RMSE, R² is below 0
    and says no more than that: a fleet in steady motion hardly varies.
    """

    rmse: float
    r2: float
    spread: float


def smallest_gaps(gap: Floats) -> Floats:
    """The three smallest gaps at each time (T, 3), m; all of them where there are fewer."""
    gap = gap[:, ~np.isnan(gap).any(axis=0)]
    k = min(3, gap.shape[1])
    return np.asarray(np.partition(gap, k - 1, axis=1)[:, :k])


def largest_gaps(gap: Floats) -> Floats:
    """The three largest gaps at each time (T, 3), m; all of them where there are fewer."""
    return -smallest_gaps(-gap)


def min_distance(gap: Floats) -> Floats:
    """MinDistance (T,), m: mean of the three smallest gaps (paper Section IV)."""
    return np.asarray(smallest_gaps(gap).mean(axis=1))


def max_distance(gap: Floats) -> Floats:
    """MaxDistance (T,), m: mean of the three largest gaps (paper Section IV)."""
    return np.asarray(largest_gaps(gap).mean(axis=1))


def fit(values: NDArray[Any], truth: NDArray[Any]) -> Fit | None:
    """Agreement over all times and vehicles at which there is a value; None where there is none."""
    known = ~(np.isnan(values) | np.isnan(truth))
    if not known.any():
        return None
    error, true = values[known] - truth[known], truth[known]
    total = float(((true - true.mean()) ** 2).sum())
    residual = float((error**2).sum())
    return Fit(
        rmse=float(np.sqrt(residual / error.size)),
        r2=1.0 - residual / total if total > 0.0 else float("nan"),
        spread=float(np.sqrt(total / error.size)),
    )


def telling(r2: float) -> float | None:
    """R² where it tells something: None below 0, and where the truth does not vary at all."""
    return r2 if r2 >= 0.0 else None
