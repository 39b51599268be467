"""Covariances and gains of many Kalman filters of one model.

They depend on which periods had a measurement, and on its variances, but not on its values. While
every period has one, filters walk the graph of `gains` together. A filter that misses a measurement
has its own history, so it leaves the graph. filterpy computes all such filters at once, on arrays
in place of floats.
"""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.gain_table import gain_table
from zenvoy.vehicles.arrays.kalman import step
from zenvoy.vehicles.arrays.rows import Floats, Ints, Rows, anywhere, within
from zenvoy.vehicles.steps import Number


class Covariances:
    """The covariances of `count` filters; `gains.Covariance` is that of one.

    The state of each filter has `size` numbers.
    """

    def __init__(self, period_s: float, acceleration_std: float, size: int, count: int) -> None:
        self._size = size
        self._table = gain_table(period_s, acceleration_std, size)
        self._variances = np.zeros((size, count))
        self._point = np.full(count, -1, dtype=np.int64)  # number on the graph; -1 off it
        self._left = np.zeros(count, dtype=np.bool_)  # filters that have begun and left it
        self._off = 0  # number of these filters
        self._P: Floats = np.zeros((size, size, count))  # of the filters off the graph
        self._settled = np.zeros(count, dtype=np.bool_)  # likewise
        self.K: Floats = np.zeros((size, size, count))

    def start(self, rows: Rows, variances: Floats) -> None:
        """Begin with a first measurement of these variances, (size, r): P = R."""
        self._variances[:, rows] = variances
        points = self._point[rows]
        self._off -= int(np.count_nonzero(self._left[rows]))
        self._left[rows] = False
        found: dict[tuple[float, ...], int] = {}
        for at, key in enumerate(zip(*variances.tolist(), strict=True)):
            if key not in found:
                found[key] = self._table.first(key)
            points[at] = found[key]
        self._put(rows, points)

    def step(self, rows: Rows, periods: Ints | int, variances: Floats) -> None:
        """Predict over some periods, (r,), and process a measurement with these variances."""
        self._change(rows, variances)
        points = self._point[rows]
        if isinstance(periods, int) and not self._off:  # nearly always
            following = self._table.after(points)
            if self._table.has_room:
                self._put(rows, following, points)
                return
        many = np.broadcast_to(periods, points.shape)
        walks = (points >= 0) & (many == 1)
        following = np.full(len(points), -1)
        following[walks] = self._table.after(points[walks])
        walks = following >= 0
        self._leave(within(rows, np.flatnonzero((points >= 0) & ~walks)))
        on = np.flatnonzero(walks)
        if on.size:
            self._put(within(rows, on), following[on], points[on])
        off = np.flatnonzero(~walks)
        steady = self._settled[within(rows, off)] & (many[off] == 1)
        off = off[~steady]
        if off.size:
            self._compute(within(rows, off), many[off])

    def gain(self, rows: Rows) -> list[list[Number]]:
        """Return the gains K of some filters, entry by entry."""
        return [[self.K[i, j, rows] for j in range(self._size)] for i in range(self._size)]

    def std(self) -> Floats:
        """Return the standard deviation of each entry of the states, (size, count)."""
        on = self._point >= 0
        variances = [
            np.where(on, self._table.P[i, i, self._point], self._P[i, i]) for i in range(self._size)
        ]
        return np.asarray(np.sqrt(np.array(variances)))

    def _change(self, rows: Rows, variances: Floats) -> None:
        """Set the variances of some filters."""
        differs = variances != self._variances[:, rows]
        if not anywhere(differs):
            return
        changed = np.flatnonzero(differs.any(axis=0))
        which = within(rows, changed)
        new = variances[:, changed]
        members = np.arange(len(self._point))[which]
        self._variances[:, members] = new
        for member, key in zip(members.tolist(), zip(*new.tolist(), strict=True), strict=True):
            point = int(self._point[member])
            if point < 0:
                self._settled[member] = False
                continue
            moved = self._table.elsewhere(point, key)
            self._point[member] = moved

    def _leave(self, rows: Rows) -> None:
        """Take some filters off the graph, with the covariances that they have there."""
        points = self._point[rows]
        self._P[:, :, rows] = self._table.P[:, :, points]
        self._settled[rows] = False
        self._left[rows] = True
        self._off += len(points)
        self._point[rows] = -1

    def _put(self, rows: Rows, points: Ints, before: Ints | None = None) -> None:
        moved = np.arange(len(points))
        if before is not None:
            differs = points != before
            if not anywhere(differs):
                return
            moved = np.flatnonzero(differs)
        which, to = within(rows, moved), points[moved]
        self._point[which] = to
        self.K[:, :, which] = self._table.K[:, :, to]

    def _compute(self, rows: Rows, periods: Ints) -> None:
        """Step some filters that are off the graph."""
        before, gain = self._P[:, :, rows], self.K[:, :, rows]
        found = step(self._table.kalman, before, gain, self._variances[:, rows], periods)
        self._settled[rows] = found.settled
        self._P[:, :, rows], self.K[:, :, rows] = found.P, found.K
