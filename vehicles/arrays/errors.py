"""Variances of the readings of many vehicles, which depend on the size of each reading."""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.rows import Floats, Rows, anywhere
from zenvoy.vehicles.estimator import LEAST_SIZE, ReadingError


class ReadingErrors:
    """The variances of `count` readings. Each keeps its variance until its size changes."""

    def __init__(self, error: ReadingError, count: int) -> None:
        self._error = error
        self._low, self._high, self._variance = np.zeros((3, count))

    def variance(self, rows: Rows, value: Floats) -> Floats:
        """Return the variances of readings of about `value`, (r,), of some vehicles."""
        size = np.maximum(np.abs(value), LEAST_SIZE)
        low, high, variance = self._low[rows], self._high[rows], self._variance[rows]
        outside = (size < low) | (size > high)
        if not anywhere(outside):
            return variance
        for at in np.flatnonzero(outside).tolist():
            low[at], high[at], variance[at] = self._error.around(float(size[at]))
        self._low[rows], self._high[rows], self._variance[rows] = low, high, variance
        return variance
