"""The graph of covariances of `gains`, numbered, so that arrays can walk it."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from zenvoy.vehicles.arrays.kalman import step
from zenvoy.vehicles.arrays.rows import Floats, Ints
from zenvoy.vehicles.gains import kalman_filter

_MOST: Final = 200_000  # points; a filter that needs another one leaves the graph


class GainTable:
    """The points of the graph by number, with P and K of each.

    A measurement in the next period leads from each point to another one.
    """

    def __init__(self, period_s: float, acceleration_std: float, size: int) -> None:
        self.kalman = kalman_filter(period_s, acceleration_std, size)
        self._size = size
        self._numbers: dict[tuple[tuple[float, ...], bytes], int] = {}
        self._count, self._room = 0, 0
        self.P: Floats = np.zeros((size, size, 0))
        self.K: Floats = np.zeros((size, size, 0))
        self._variances: Floats = np.zeros((size, 0))
        self._after: Ints = np.zeros(0, dtype=np.int64)
        self._make_room(1_024)

    @property
    def has_room(self) -> bool:
        """Whether the table can hold further points."""
        return self._count < _MOST

    def first(self, variances: tuple[float, ...]) -> int:
        """Return the point after a first measurement."""
        eye = np.eye(self._size)
        return self._known(variances, eye * np.array(variances), eye)

    def elsewhere(self, point: int, variances: tuple[float, ...]) -> int:
        """Return the point with the covariance of `point` on the graph of other variances."""
        return self._known(variances, self.P[:, :, point], self.K[:, :, point])

    def after(self, points: Ints) -> Ints:
        """Return the points after a measurement in the next period; -1 is off the graph."""
        following = self._after[points]
        if following.size and following.min() < 0 and self.has_room:
            self._explore(np.unique(points[following < 0]))
            following = self._after[points]
        return following

    def _explore(self, points: Ints) -> None:
        """Compute the points that follow some points."""
        variances = self._variances[:, points]
        once = np.ones(len(points), dtype=np.int64)
        found = step(self.kalman, self.P[:, :, points], self.K[:, :, points], variances, once)
        self._after[points[found.settled]] = points[found.settled]
        new = np.flatnonzero(~found.settled)
        numbers = self._add(variances[:, new], found.P[:, :, new], found.K[:, :, new])
        self._after[points[new]] = numbers

    def _known(self, variances: tuple[float, ...], P: Floats, K: Floats) -> int:
        """Return the point with these variances and this P; add it if it is new."""
        key = (variances, P.tobytes())
        number = self._numbers.get(key)
        if number is None:
            column = np.array(variances)[:, None]
            number = self._numbers[key] = int(self._add(column, P[:, :, None], K[:, :, None])[0])
        return number

    def _add(self, variances: Floats, P: Floats, K: Floats) -> Ints:
        numbers = np.arange(self._count, self._count + P.shape[2])
        self._count += len(numbers)
        if self._count > self._room:
            self._make_room(2 * self._count)
        self.P[:, :, numbers], self.K[:, :, numbers] = P, K
        self._variances[:, numbers] = variances
        return numbers

    def _make_room(self, room: int) -> None:
        more = room - self._room
        self._room = room
        square = np.zeros((self._size, self._size, more))
        self.P, self.K = (np.concatenate([table, square], axis=2) for table in (self.P, self.K))
        self._variances = np.concatenate([self._variances, square[0]], axis=1)
        self._after = np.concatenate([self._after, np.full(more, -1)])


@lru_cache(maxsize=16)
def gain_table(period_s: float, acceleration_std: float, size: int) -> GainTable:
    """Return the table of a model, shared by all filters of this process."""
    return GainTable(period_s, acceleration_std, size)
