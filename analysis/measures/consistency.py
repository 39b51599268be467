"""Checks that a filter is consistent: that its errors are as large as the variance it states.

See Bar-Shalom, Li and Kirubarajan 2001, Section 5.4. The squared errors of a consistent filter,
divided by its variance, follow χ² with one degree of freedom, so their mean is 1. The mean over m
independent ones has a 95 % interval from the quantiles of χ²(m) / m. Here the m are the vehicles of
one cycle, as their sensors err independently. The errors of one filter are correlated over time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

Floats = NDArray[np.float64]


class Spread(NamedTuple):
    """Shares of errors within 1, 2 and 3 standard deviations: 0.683, 0.954, 0.997 if normal."""

    within_1: float
    within_2: float
    within_3: float


class Consistency(NamedTuple):
    """Mean over the vehicles in each cycle with its 95 % interval (cycles,), and over the run.

    Cycles in which no vehicle had a value are NaN. `share_inside` is the share of the cycles whose
    mean is within the interval.
    """

    per_cycle: Floats
    low: Floats
    high: Floats
    mean: float
    share_inside: float


def spread(error: Floats, std: Floats) -> Spread | None:
    """Compare errors with the filter's standard deviations; None where no error is known."""
    known = ~(np.isnan(error) | np.isnan(std))
    if not known.any():
        return None
    size, unit = np.abs(error[known]), std[known]
    return Spread(*(float((size <= k * unit).mean()) for k in (1, 2, 3)))


def normalised_error(error: Floats, std: Floats) -> Floats:
    """Return the NEES of one component, (x̂ - x)² / P; its mean is 1 for a consistent filter.

    It is computed by component, because the log has only the diagonal of P.
    """
    return np.asarray((error / np.where(std > 0.0, std, np.nan)) ** 2)


def normalised_innovation(
    measured: Floats, estimated: Floats, std: Floats, reading_variance: Floats
) -> Floats:
    """Return the NIS of one component from what is logged after the update; NaN if unknown.

    The innovation z - x̂⁻ and its covariance S = P⁻ + R are not in the log, but the residual after
    the update is: z - x̂ = (1 - K)(z - x̂⁻). For the Kalman gain K and H = I its variance is
    (1 - K) S (1 - K)' = R S⁻¹ R = R - P. Normalised, residual and innovation are the same number:
    (z - x̂)² / (R - P). For a state of two components this holds for the quadratic form, and each
    component still follows χ² with one degree of freedom. So neither the gain nor the prediction,
    which depends on the beacons that the filter received, is needed.

    R is the true variance of the sensors, not the filter's assumption, so this checks that readings
    scatter around the estimates as they should. Values with P > R / 2 are left out: the filter has
    just started, and R - P would be a small difference of large numbers. Uniform reading errors
    have the variance R but lighter tails. The mean is still 1, but the variance of the squares is
    0.8 instead of 2 (the fourth moment), so more than 95 % of the cycles are within the interval.
    """
    variance = reading_variance - std**2
    settled = std**2 <= 0.5 * reading_variance
    safe = np.where(settled & (variance > 0.0), variance, np.nan)
    return np.asarray((measured - estimated) ** 2 / safe)


def consistency(normalised: Floats) -> Consistency | None:
    """Compare normalised squares (cycles, vehicles) with χ²; NaN are left out, None if all are."""
    known = ~np.isnan(normalised)
    count = known.sum(axis=1)
    some = count > 0
    if not some.any():
        return None
    total = np.where(known, normalised, 0.0).sum(axis=1)
    per_cycle, low, high = (np.full(len(count), np.nan) for _ in range(3))
    per_cycle[some] = total[some] / count[some]
    low[some], high[some] = interval(count[some])
    inside = (per_cycle[some] >= low[some]) & (per_cycle[some] <= high[some])
    return Consistency(
        per_cycle=per_cycle,
        low=low,
        high=high,
        mean=float(total.sum() / count.sum()),
        share_inside=float(inside.mean()),
    )


def interval(count: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return the 95 % interval of the mean of m = `count` squared standard normals: χ²(m) / m."""
    half = count / 2.0
    return gammaincinv(half, 0.025) / half, gammaincinv(half, 0.975) / half
