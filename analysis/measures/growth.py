"""Measures how the swing of speed grows from vehicle to vehicle of a convoy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

Floats = NDArray[np.float64]

_OUTSIDE = 0.025  # on each side of a 95 % interval


class Median(NamedTuple):
    """Median of n values, and its 95 % interval; NaN for fewer than six values."""

    median: float
    low: float
    high: float
    n: int


def growths(speed: Floats) -> Floats:
    """Return the growth (n - 1,) of the swing from each vehicle to the next.

    The swing is the standard deviation of the speed (T, n) over time. The growth is its ratio.
    """
    swing = speed.std(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(swing[1:] / swing[:-1])


def growth_per_vehicle(speed: Floats) -> float:
    """Return the growth per vehicle from the first to the last of a convoy, speeds (T, n).

    It is the geometric mean of the growths from vehicle to vehicle.
    """
    swing = speed.std(axis=0)
    return float((swing[-1] / swing[0]) ** (1.0 / (len(swing) - 1)))


def median_of(values: Sequence[float] | Floats) -> Median:
    """Return the median of at least one value, with an interval from order statistics.

    The interval holds for any distribution (Conover 1999, "Practical Nonparametric Statistics",
    section 3.2): the number of values below the median is binomial.
    """
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    n = len(ordered)
    outside = int(binom.ppf(_OUTSIDE, n, 0.5))
    while outside and binom.cdf(outside - 1, n, 0.5) > _OUTSIDE:
        outside -= 1
    low, high = (np.nan, np.nan)
    if outside:
        low, high = ordered[outside - 1], ordered[n - outside]
    return Median(float(np.median(ordered)), float(low), float(high), n)
