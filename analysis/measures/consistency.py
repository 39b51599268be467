"""Whether a filter errs as it says it does (Bar-Shalom, Li and Kirubarajan 2001, Section 5.4).

Squared errors, normalised by the variance that the filter claims, are χ² distributed with one
degree of freedom where filter and claim are right: their mean is 1. The mean over m independent
ones has a 95 % interval from the quantiles of χ²(m) / m. Here the m are the vehicles of one cycle,
whose sensors err independently; over time the errors of a filter hang together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

Floats = NDArray[np.float64]


class Spread(NamedTuple):
    """Shares of the errors within 1, 2 and 3 standard deviations; 0.683, 0.954, 0.997 if normal."""

    within_1: float
    within_2: float
    within_3: float


class Consistency(NamedTuple):
    """Mean over the vehicles per cycle (cycles,), its 95 % interval, and both over the run.

    NaN where no vehicle had a value; `share_inside` is that of the cycles within the interval.
    """

    per_cycle: Floats
    low: Floats
    high: Floats
    mean: float
    share_inside: float


def spread(error: Floats, std: Floats) -> Spread | None:
    """How errors lie against the standard deviations claimed for them; None where none is known."""
    known = ~(np.isnan(error) | np.isnan(std))
    if not known.any():
        return None
    size, unit = np.abs(error[known]), std[known]
    return Spread(*(float((size <= k * unit).mean()) for k in (1, 2, 3)))


def normalised_error(error: Floats, std: Floats) -> Floats:
    """NEES of one component: (x̂ - x)² / P, from the truth. Mean 1 if consistent.

    Component by component, since the log has the diagonal of P only.
    """
    return np.asarray((error / np.where(std > 0.0, std, np.nan)) ** 2)


def normalised_innovation(
    measured: Floats, estimated: Floats, std: Floats, reading_variance: Floats
) -> Floats:
    """NIS of one component from what is logged after the update; NaN where it cannot be told.

    The innovation z - x̂⁻ and its covariance S = P⁻ + R are not in the log, the residual after the
    update is: z - x̂ = (1 - K)(z - x̂⁻), whose variance is (1 - K) S (1 - K)' = R S⁻¹ R = R - P for
    the Kalman gain K and H = I. Normalised, both are the same number: (z - x̂)² / (R - P). For a
    state of two this is so as a quadratic form; of its components, each is χ² with one degree of
    freedom all the same. Needs neither gain nor what the filter predicted, which depends on what
    it heard of its neighbour.

    R is that of the sensors, not the filter's idea of it, so it says whether readings scatter
    around the estimates as they should. Left out where P > R / 2: the filter has just started, and
    R - P would be the difference of two numbers of a size. Reading errors that are uniform have
    the variance of R but lighter tails: the mean stays 1, its scatter is that of 0.8 in place of
    2 (the fourth moment), so more than 95 % of the cycles lie within the interval.
    """
    variance = reading_variance - std**2
    settled = std**2 <= 0.5 * reading_variance
    safe = np.where(settled & (variance > 0.0), variance, np.nan)
    return np.asarray((measured - estimated) ** 2 / safe)


def consistency(normalised: Floats) -> Consistency | None:
    """Judge normalised squares (cycles, vehicles), NaN left out; None where there are none."""
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
    """95 % interval of the mean of `count` squares of standard normal numbers: χ²(m) / m."""
    half = count / 2.0
    return gammaincinv(half, 0.025) / half, gammaincinv(half, 0.975) / half
