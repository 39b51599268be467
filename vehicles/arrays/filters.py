"""Kalman filters of the links and the own speeds of many vehicles at once.

They use the formulas of `estimator.Filter`.
"""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.covariances import Covariances
from zenvoy.vehicles.arrays.errors import ReadingErrors
from zenvoy.vehicles.arrays.rows import ALL, Floats, Ints, Rows
from zenvoy.vehicles.estimator import ReadingError, advanced, corrected


class LinkFilters:
    """Filters of `count` links, with states p (m) and v (m/s).

    Each state is at the cycle of the link's newest measurement.
    """

    def __init__(
        self,
        period_s: float,
        acceleration_std: float,
        gap_error: ReadingError,
        speed_error: ReadingError,
        count: int,
    ) -> None:
        self._period_s = period_s
        self._gap_error = ReadingErrors(gap_error, count)
        self._speed_error = ReadingErrors(speed_error, count)
        self.covariances = Covariances(period_s, acceleration_std, 2, count)
        self.p, self.v = np.zeros(count), np.zeros(count)
        self.measured = np.full(count, -1, dtype=np.int64)
        """Cycle of the newest measurement; -1 if there is none yet."""
        self._all_started = False

    @property
    def started(self) -> bool:
        """Whether every link has been measured."""
        self._all_started = self._all_started or bool((self.measured >= 0).all())
        return self._all_started

    def advance(self, rows: Rows, a: Floats) -> None:
        """Predict some links over a period with the relative accelerations a (m/s²)."""
        p, v = advanced(self.p[rows], self.v[rows], a, self._period_s)
        self._put(rows, p, v)

    def variances(self, rows: Rows, gap: Floats, speed: Floats) -> Floats:
        """Return R's diagonal, (2, r), for readings at about these gaps and speeds."""
        return np.array(
            (self._gap_error.variance(rows, gap), self._speed_error.variance(rows, speed))
        )

    def correct(
        self, rows: Rows, cycle: int, periods: Ints | int, z: tuple[Floats, Floats], r: Floats
    ) -> None:
        """Process readings z of a cycle, (r,) each, for links that were advanced to it."""
        self.covariances.step(rows, periods, r)
        gain = self.covariances.gain(rows)
        p, v = corrected(self.p[rows], self.v[rows], *z, gain)
        self._put(rows, p, v)
        self.measured[rows] = cycle

    def start(self, rows: Rows, cycle: int, z: tuple[Floats, Floats], r: Floats) -> None:
        """Start the filters of some links with readings z of a cycle."""
        self.covariances.start(rows, r)
        self._put(rows, z[0].copy(), z[1].copy())  # later steps change some entries in place
        self.measured[rows] = cycle

    def _put(self, rows: Rows, p: Floats, v: Floats) -> None:
        if isinstance(rows, slice):
            self.p, self.v = p, v
        else:
            self.p[rows], self.v[rows] = p, v


class SpeedFilters:
    """Filters of the own speeds of `count` vehicles, m/s, which are measured in every cycle."""

    def __init__(
        self, period_s: float, acceleration_std: float, error: ReadingError, count: int
    ) -> None:
        self._period_s = period_s
        self._errors = ReadingErrors(error, count)
        self.covariances = Covariances(period_s, acceleration_std, 1, count)
        self.v: Floats | None = None

    def measure(self, reading: Floats, acceleration: Floats) -> None:
        """Predict over a period with `acceleration` (m/s²), and process the next readings (m/s)."""
        if self.v is None:
            self.covariances.start(ALL, self._errors.variance(ALL, reading)[None])
            self.v = reading
            return
        self.covariances.step(ALL, 1, self._errors.variance(ALL, self.v)[None])
        ((gain,),) = self.covariances.gain(ALL)
        predicted = self.v + self._period_s * (0 + acceleration)
        self.v = predicted + gain * (reading - predicted)
