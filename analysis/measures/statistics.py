"""Means over seeds, with their confidence intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

_CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class Mean:
    """Mean of n independent values and its 95 % confidence interval (Student's t)."""

    mean: float
    low: float
    high: float
    n: int

    def above(self, other: Mean) -> bool:
        """Return whether the whole interval lies above the other's."""
        return self.low > other.high

    def text(self, digits: int = 2, unit: str = "") -> str:
        """Return text such as "36.70 ± 0.02 m"."""
        half = (self.high - self.low) / 2.0
        spread = "" if np.isnan(half) else f" ± {half:.{digits}f}"
        return f"{self.mean:.{digits}f}{spread}{unit and ' ' + unit}"


def mean_of(values: Sequence[float]) -> Mean:
    """Return the mean of at least one value; the interval of a single value is NaN."""
    n = len(values)
    mean, half = (float(np.asarray(part)) for part in mean_and_half(np.array(values)[:, None]))
    return Mean(mean=mean, low=mean - half, high=mean + half, n=n)


def mean_and_half(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean over axis 0 of (n, ...) and half its 95 % interval, both (...)."""
    n = len(values)
    mean = np.asarray(values.mean(axis=0)).squeeze()
    if n < 2:
        return mean, np.full(mean.shape, np.nan)
    error = np.asarray(values.std(axis=0, ddof=1)).squeeze() / np.sqrt(n)
    return mean, np.asarray(student.ppf(0.5 + _CONFIDENCE / 2.0, n - 1) * error)
