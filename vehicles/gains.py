"""Kalman gains, computed by filterpy, each only once.

Given F, Q and R, covariance and gain depend on which periods had a measurement, never on the
measured values. So all filters of a model, for any vehicle and link, walk the same graph of
covariances. In a steady flow of measurements the walk ends in a point that leads to itself:
filterpy's steady state.

filterpy gets arrays of Python's floats (dtype object). numpy's own products go through BLAS, which
uses different kernels on different processors, and gains would differ in their last bits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.vehicles.filterpy_kalman import KalmanFilter
from zenvoy.vehicles.linear import Array, linear_model
from zenvoy.vehicles.steps import Number
from zenvoy.vehicles.transcribed import Matrix, Model, predicted, updated

Objects = NDArray[np.object_]

SETTLED: Final = 1e-13
"""The gain counts as settled when a step changes no entry of P by more than this share of P."""

# Losses keep making new histories; after this many points they are computed but not kept, and
# those of links in plain floats (`transcribed`).
_KEEP: Final = 4_096


class Covariance:
    """A point of the graph: P (n, n) after an update, its gain K and its standard deviations."""

    __slots__ = ("K", "P", "after", "std")

    def __init__(self, P: Array, K: list[list[float]]) -> None:
        self.P = P
        self.K = K
        self.std = tuple(math.sqrt(variance) for variance in P.diagonal().tolist())
        self.after: dict[int, Covariance] = {}


class GainSchedule:
    """The graph of one model: x = [p, v] or [v], period in s, σ_a in m/s², diagonal of R."""

    def __init__(
        self, period_s: float, acceleration_std: float, variances: tuple[float, ...]
    ) -> None:
        size = len(variances)
        self._kalman = kalman_filter(period_s, acceleration_std, size)
        self._kalman.R = np.diag(variances).astype(object)
        self._kept = 0
        kalman = self._kalman
        self._model: Model | None = None
        if size > 1:
            self._model = Model(*(_flat(matrix) for matrix in (kalman.F, kalman.Q, kalman.R)))
        self.first = Covariance(np.diag(variances), np.eye(size).tolist())

    def step(self, before: Covariance, periods: int) -> Covariance:
        """Return the covariance after `periods` predictions and an update."""
        known = before.after.get(periods)
        if known is not None:
            return known
        if self._model is not None and self._kept >= _KEEP:
            after = _transcribed(before, periods, self._model)
        else:
            after = self._compute(before, periods)
        if self._kept < _KEEP or after is before:
            self._kept += 1
            before.after[periods] = after
        return after

    def _compute(self, before: Covariance, periods: int) -> Covariance:
        kalman = self._kalman
        kalman.P = before.P.astype(object)
        for _ in range(periods):
            kalman.predict()
        kalman.update(np.zeros(kalman.dim_z))
        if periods == 1:
            updated, entries = kalman.P.ravel().tolist(), before.P.ravel().tolist()
            change = max(abs(new - old) for new, old in zip(updated, entries, strict=True))
            if change <= SETTLED * max(map(abs, updated)):
                return before
        return Covariance(kalman.P.astype(np.float64), kalman.K.tolist())


def _transcribed(before: Covariance, periods: int, model: Model) -> Covariance:
    """Return what `GainSchedule._compute` does, with filterpy's products one by one."""
    P = start = _flat(before.P)
    for _ in range(periods):
        P = predicted(P, model)
    P, K = updated(P, model)
    if periods == 1:
        change = max(abs(new - old) for new, old in zip(P, start, strict=True))
        if change <= SETTLED * max(map(abs, P)):
            return before
    return Covariance(np.array(P).reshape(2, 2), [[K[0], K[1]], [K[2], K[3]]])


def _flat(matrix: NDArray[Any]) -> Matrix:
    a, b, c, d = matrix.ravel().tolist()
    return a, b, c, d


def kalman_filter(period_s: float, acceleration_std: float, size: int) -> KalmanFilter:
    """Return filterpy's filter of a model, without its R.

    Its matrices hold Python objects: floats, or arrays of them, one for each of many filters.
    """
    kalman = KalmanFilter(dim_x=size, dim_z=size, dim_u=1)
    model = linear_model(period_s, acceleration_std, size)
    kalman.F, kalman.B, kalman.Q = (matrix.astype(object) for matrix in model)
    kalman.H = np.eye(size).astype(object)
    kalman.inv = inverse
    return kalman


def inverse(S: Objects) -> Objects:
    """Return S⁻¹ of a matrix (1, 1) or (2, 2) of floats or arrays; raises LinAlgError."""
    if S.shape == (1, 1):
        determinant, adjugate = S[0, 0], [[1.0]]
    else:
        a, b, c, d = S.ravel()
        determinant = a * d - b * c
        adjugate = [[d, -b], [-c, a]]
    if np.any(determinant == 0.0):
        raise np.linalg.LinAlgError("Singular matrix")
    return objects([[x / determinant for x in row] for row in adjugate])


def objects(rows: Sequence[Sequence[Number]]) -> Objects:
    """Return a matrix (n, n) whose entries are these floats or arrays."""
    matrix = np.empty((len(rows), len(rows)), dtype=object)
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            matrix[i, j] = entry
    return matrix


@lru_cache(maxsize=256)
def gain_schedule(
    period_s: float, acceleration_std: float, variances: tuple[float, ...]
) -> GainSchedule:
    """Return the schedule of a model, shared by all filters of this process."""
    return GainSchedule(period_s, acceleration_std, variances)


def settle(schedule: GainSchedule) -> int:
    """Walk a schedule to its settled point, and return the number of steps.

    It is worth doing before a fork: children then share what each of them would compute, as long as
    every period has a measurement.
    """
    point, steps = schedule.first, 0
    while steps < _KEEP and (after := schedule.step(point, 1)) is not point:
        point, steps = after, steps + 1
    return steps
