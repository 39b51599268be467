"""The filtered offsets of many links; `link_offset.LinkOffset` is that of one."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.filters import LinkFilters
from zenvoy.vehicles.arrays.odometers import picked, relative
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints, Rows, everywhere, within
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.link_errors import link_errors
from zenvoy.vehicles.link_offset import GIVE_UP_PERIODS
from zenvoy.vehicles.odometer import Odometer, offset_of, state_of
from zenvoy.vehicles.steps import NS, Number

_STILL: Final[Floats] = np.zeros(1)


class Readings(NamedTuple):
    """The readings of the vehicles at the start of a cycle, as `link_offset.Reading`."""

    odometer: Odometer
    radar: Relative
    speed: Floats

    def of(self, rows: Rows) -> Readings:
        """Return the readings of some vehicles."""
        return Readings(picked(self.odometer, rows), relative(self.radar, rows), self.speed[rows])


class Offsets:
    """The offsets of the links ahead of `count` vehicles."""

    def __init__(self, scenario: Scenario, timing: Timing, count: int) -> None:
        gap_error, speed_error = link_errors(scenario)
        period_s, sigma = timing.period_ns * NS, scenario.estimator.acceleration_std_mps2
        self._timing = timing
        self._filters = LinkFilters(period_s, sigma, gap_error, speed_error, count)

    @property
    def measured(self) -> Ints:
        """The cycle of the newest measurement of each link; -1 before the first one."""
        return self._filters.measured

    @property
    def known(self) -> Bools | None:
        """Return which links have been measured; None means all of them."""
        return None if self._filters.started else self.measured >= 0

    def std(self) -> Floats:
        """Standard deviations of the offsets, (2, count), m and m/s."""
        return self._filters.covariances.std()

    def at(self, cycle: int) -> Relative:
        """Return the offsets at the start of a cycle."""
        p, v = self._filters.p, self._filters.v
        return Relative(p + v * self._since_s(cycle, 0), v.copy())  # v changes in place

    def state(self, cycle: int, after_ns: int, front: Odometer, rear: Odometer) -> Relative:
        """Return the states of the links some time after the start of a cycle."""
        offset = Relative(self._filters.p, self._filters.v)
        return state_of(offset, self._since_s(cycle, after_ns), front, rear)

    def measure(self, rows: Rows, cycle: int, readings: Readings, front: Odometer) -> None:
        """Process the readings (r,) of a cycle for which the odometers in front are known."""
        filters = self._filters
        periods = cycle - self.measured[rows]
        goes_on = (self.measured[rows] >= 0) & (periods <= GIVE_UP_PERIODS)
        offset = Relative(filters.p[rows], filters.v[rows])
        since_s = (periods * self._timing.period_ns) * NS
        expected: Floats = state_of(offset, since_s, front, readings.odometer).p
        read: Floats = readings.radar.p
        gap = np.where(goes_on, expected, read)
        z = offset_of(readings.radar, front, readings.odometer)
        r = filters.variances(rows, gap, readings.speed)
        if everywhere(goes_on & (periods == 1)):  # nearly always
            filters.advance(rows, _STILL)
            filters.correct(rows, cycle, 1, z, r)
            return
        some = np.flatnonzero(~goes_on)
        if some.size:
            filters.start(within(rows, some), cycle, relative(z, some), r[:, some])
        some = np.flatnonzero(goes_on)
        if not some.size:
            return
        for back in range(int(periods[some].max()), 0, -1):
            filters.advance(within(rows, some[periods[some] >= back]), _STILL)
        filters.correct(within(rows, some), cycle, periods[some], relative(z, some), r[:, some])

    def _since_s(self, cycle: int, after_ns: int) -> Number:
        """Return the time from the newest measurements to `after_ns` after a cycle's start."""
        return ((cycle - self.measured) * self._timing.period_ns + after_ns) * NS
