"""Steps the covariances of many Kalman filters at once: filterpy computes on arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints
from zenvoy.vehicles.filterpy_kalman import KalmanFilter
from zenvoy.vehicles.gains import SETTLED, objects
from zenvoy.vehicles.steps import Number


class Step(NamedTuple):
    """P and K (n, n, r) after a step, and the filters (r,) that it no longer changes."""

    P: Floats
    K: Floats
    settled: Bools


def step(kalman: KalmanFilter, before: Floats, K: Floats, variances: Floats, periods: Ints) -> Step:
    """Return P and K of each filter after a number of predictions, `periods` (r,), and an update.

    before is P (n, n, r) before the step, kalman is filterpy's filter of the model, and variances
    are the diagonals of R, (n, r). Settled filters keep their P and K, as in `gains.GainSchedule`.
    """
    size = len(before)
    predicted = before.copy()
    for number in range(1, int(periods.max()) + 1):
        on = periods >= number
        kalman.P = objects([list(row) for row in predicted[:, :, on]])
        kalman.predict()
        predicted[:, :, on] = _stacked(kalman.P, int(np.count_nonzero(on)))
    kalman.P = objects([list(row) for row in predicted])
    zero = np.zeros(variances.shape[1])
    kalman.R = objects(
        [[row if i == j else zero for j in range(size)] for i, row in enumerate(variances)]
    )
    kalman.x = np.zeros(size, dtype=object)
    kalman.update(np.zeros(size))
    updated = _stacked(kalman.P, len(periods))
    change = np.abs(updated - before).max(axis=(0, 1))
    settled: Bools = (periods == 1) & (change <= SETTLED * np.abs(updated).max(axis=(0, 1)))
    gains = np.where(settled, K, _stacked(kalman.K, len(periods)))
    return Step(np.where(settled, before, updated), gains, settled)


def _stacked(matrix: Number, count: int) -> Floats:
    """Return a matrix of arrays as one array."""
    size = len(matrix)
    stacked = np.empty((size, size, count))
    for i, row in enumerate(matrix):
        for j, entry in enumerate(row):
            stacked[i, j] = entry
    return stacked
