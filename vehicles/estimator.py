"""Kalman filters of a link (gap, relative speed) and of the own speed.

The models are those of the paper, Eq. 4 to 14: x = [p, v], F = [[1, T], [0, 1]],
B = [T²/2, T], H = I, with the relative acceleration that acted as input. The own speed has the
same model without its first row. filterpy computes covariances and gains (`gains.py`). Given the
gain, the state takes a handful of products, for which arrays would take ten times as long.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from zenvoy.vehicles.gains import Covariance, gain_schedule
from zenvoy.vehicles.linear import Array
from zenvoy.vehicles.steps import Number

# R follows the size of readings in steps of this ratio, so that the gain can settle in between.
_RESCALE: Final = 1.25

LEAST_SIZE: Final = 0.1
"""A reading counts as at least this large, m or m/s, because its error is never 0."""


def advanced(p: Number, v: Number, a: Number, period_s: float) -> tuple[Number, Number]:
    """Return gap (m) and relative speed (m/s) a period later: x' = F x + B a."""
    return p + period_s * (v + 0.5 * period_s * a), v + period_s * a


def corrected(
    p: Number, v: Number, read_p: Number, read_v: Number, gain: Sequence[Sequence[Number]]
) -> tuple[Number, Number]:
    """Return x = x' + K (z - x'), with x' = [p, v] and z = [read_p, read_v]."""
    (k_pp, k_pv), (k_vp, k_vv) = gain
    dp, dv = read_p - p, read_v - v
    return p + k_pp * dp + k_pv * dv, v + k_vp * dp + k_vv * dv


class ReadingError:
    """The variance of readings whose error is a share of their size.

    `nominal` is a usual reading; the variance is exact for it until a reading of another size
    arrives. `floor` is the least standard deviation of any reading.
    """

    __slots__ = ("_floor", "_high", "_low", "_nominal", "_share", "_variance")

    def __init__(self, share_std: float, nominal: float, floor: float = 1e-3) -> None:
        self._share = share_std
        self._floor = floor
        self._nominal = max(nominal, LEAST_SIZE)
        self._low = self._high = self._variance = 0.0

    def variance(self, value: float) -> float:
        """Return the variance of a reading of about `value`, to within a factor of _RESCALE²."""
        size = max(abs(value), LEAST_SIZE)
        if not self._low <= size <= self._high:
            self._low, self._high, self._variance = self.around(size)
        return self._variance

    def around(self, size: float) -> tuple[float, float, float]:
        """Return the range of sizes that share a variance with `size`, and that variance."""
        steps = round(math.log(size / self._nominal, _RESCALE))
        used = self._nominal * _RESCALE**steps
        return used / _RESCALE, used * _RESCALE, max(self._share * used, self._floor) ** 2


class Filter:
    """The state of one model with period_s (s) and acceleration_std (σ_a, m/s²)."""

    def __init__(self, period_s: float, acceleration_std: float) -> None:
        self._period_s = period_s
        self._acceleration_std = acceleration_std
        self._variances: tuple[float, ...] = ()
        self._covariance: Covariance | None = None
        self.x: tuple[float, ...] = ()
        """State [p, v] in m and m/s, or [v]; empty before the first measurement."""

    @property
    def P(self) -> Array:
        """The covariance of the state, (n, n); raises ValueError before the first measurement."""
        if self._covariance is None:
            raise ValueError("no measurement yet")
        return self._covariance.P

    @property
    def std(self) -> tuple[float, ...]:
        """The standard deviation of each entry of the state, m and m/s."""
        return self._covariance.std if self._covariance is not None else ()

    def reset(self) -> None:
        """Forget the state; the next measurement starts the filter anew."""
        self.x, self._covariance = (), None

    def step(
        self, inputs: Sequence[float], z: tuple[float, ...], variances: tuple[float, ...]
    ) -> None:
        """Predict one period for each input, then update with the measurement z (n,).

        `inputs`: the (relative) acceleration (m/s²) that acted in each period since the last
        measurement. There are several if measurements were missed, and the covariance grows with
        each. `variances`: the diagonal of R. The first measurement sets x = z, P = R.
        """
        if variances != self._variances:
            self._variances = variances
            self._schedule = gain_schedule(self._period_s, self._acceleration_std, variances)
            if self._covariance is not None:  # the same covariance, but on another graph
                self._covariance = Covariance(self._covariance.P, self._covariance.K)
        if self._covariance is None:
            self.x, self._covariance = z, self._schedule.first
            return
        before, periods = self._covariance, len(inputs)
        after = before.after.get(periods) or self._schedule.step(before, periods)
        self._covariance = after
        period_s, gain = self._period_s, after.K
        if len(z) == 1:  # the same formulas, without their first row
            v = self.x[0] + period_s * sum(inputs)
            self.x = (v + gain[0][0] * (z[0] - v),)
            return
        p, v = self.x
        for a in inputs:
            p, v = advanced(p, v, a, period_s)
        self.x = corrected(p, v, z[0], z[1], gain)
