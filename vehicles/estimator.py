"""Kalman filters of a link (gap, relative speed) and of the own speed, on filterpy.

The models are those of the paper, Eq. 4 to 14: x = [p, v], F = [[1, T], [0, 1]],
B = [T²/2, T], H = I, with the relative acceleration that acted as input. The own speed has the
same model without its first row.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

Array = NDArray[np.float64]

# R follows the size of what is read in steps of this ratio, so that the gain can settle between.
_RESCALE: Final = 1.25
# The gain counts as settled when an update changes no entry of P by more than this share of the
# largest; looked at after every so many updates only, because looking costs as much as updating.
_SETTLED: Final = 1e-14
_LOOK_EVERY: Final = 32


class ReadingError:
    """Variance of readings that are wrong by a share of what they read."""

    __slots__ = ("_share", "_size")

    def __init__(self, share_std: float) -> None:
        self._share = share_std
        self._size = 0.0

    def variance(self, value: float) -> float:
        """Variance of a reading of about `value`, exact to within a factor of _RESCALE²."""
        size = max(abs(value), 0.1)
        if not self._size / _RESCALE <= size <= self._size * _RESCALE:
            self._size = size
        return max(self._share * self._size, 1e-3) ** 2


class Filter:
    """A filterpy filter that no longer computes a gain that has settled.

    While a measurement comes every period and R stays, P and K converge; from then on filterpy's
    steady-state methods give the same numbers at a fraction of the cost.
    """

    def __init__(self, period_s: float, acceleration_std: float, size: int) -> None:
        transition = np.array([[1.0, period_s], [0.0, 1.0]])
        control = np.array([[0.5 * period_s**2], [period_s]])
        kalman = KalmanFilter(dim_x=size, dim_z=size, dim_u=1)
        kalman.F = transition[-size:, -size:]
        kalman.B = control[-size:]
        kalman.H = np.eye(size)
        kalman.Q = acceleration_std**2 * kalman.B @ kalman.B.T
        self._kalman = kalman
        self._input = np.zeros((1, 1))
        self._z = np.zeros((size, 1))
        self._variances: tuple[float, ...] = ()
        self._std: tuple[float, ...] = ()
        self._updates = 0
        self._started = self._settled = False

    @property
    def started(self) -> bool:
        """Whether a measurement has come since the start or the last reset."""
        return self._started

    @property
    def x(self) -> list[float]:
        """State [p, v] in m and m/s, or [v]."""
        state: list[float] = self._kalman.x[:, 0].tolist()
        return state

    @property
    def P(self) -> Array:  # noqa: N802  # the letter of the field
        """Covariance of the state, (n, n)."""
        covariance: Array = self._kalman.P
        return covariance

    @property
    def std(self) -> tuple[float, ...]:
        """Standard deviation of each entry of the state, m and m/s."""
        return self._std

    def reset(self) -> None:
        """Forget the state; the next measurement starts anew."""
        self._started = self._settled = False

    def step(
        self, inputs: Sequence[float], z: Sequence[float], variances: tuple[float, ...]
    ) -> None:
        """Predict one period for each input, then take in the measurement z (n,).

        `inputs`: the (relative) acceleration (m/s²) that acted in each period since the last
        measurement; more than one where measurements were missed: the covariance grows with each.
        `variances`: the diagonal of R. The first measurement sets x = z, P = R.
        """
        kalman = self._kalman
        self._z[:, 0] = z
        if variances != self._variances:
            self._variances = variances
            self._settled = False
            kalman.R = np.diag(variances)
        if not self._started:
            kalman.x, kalman.P = self._z.copy(), kalman.R.copy()
            self._started = True
            self._remember_std()
        elif self._settled and len(inputs) == 1:
            self._input[0, 0] = inputs[0]
            kalman.predict_steadystate(self._input)
            kalman.update_steadystate(self._z)
        else:
            self._step_in_full(inputs)

    def _step_in_full(self, inputs: Sequence[float]) -> None:
        kalman = self._kalman
        before = kalman.P
        for a in inputs:
            self._input[0, 0] = a
            kalman.predict(self._input)
        kalman.update(self._z)
        self._remember_std()
        self._settled = False
        self._updates += 1
        if self._updates % _LOOK_EVERY == 0 and len(inputs) == 1:
            change = np.abs(kalman.P - before).max()
            self._settled = bool(change <= _SETTLED * np.abs(kalman.P).max())

    def _remember_std(self) -> None:
        self._std = tuple(math.sqrt(v) for v in self._kalman.P.diagonal().tolist())
