"""The filtered offset of a link: what is unknown of its gap once both odometers are known."""

from __future__ import annotations

from typing import Final, NamedTuple

from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.filters import state_filter
from zenvoy.vehicles.link_errors import link_errors
from zenvoy.vehicles.odometer import Odometer, offset_of, state_of
from zenvoy.vehicles.steps import NS

GIVE_UP_PERIODS: Final = 500
"""Periods without a measurement after which an offset is estimated anew: it may have drifted."""


class Reading(NamedTuple):
    """A vehicle's own readings at the start of a cycle, with its odometer then.

    radar: gap (m) and relative speed (m/s) to the vehicle ahead. speed: the own speed, m/s, which
    is about that of the vehicle ahead.
    """

    odometer: Odometer
    radar: Relative | None
    speed: float


class LinkOffset:
    """The offset of the link to the vehicle ahead, by the filter that the scenario chooses.

    The filter takes it for a link on which no acceleration acts.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._period_ns = scenario.period_ns
        self._filter = state_filter(scenario.estimator, scenario.period_ns, scenario.stall_limit_s)
        self._gap_error, self._speed_error = link_errors(scenario)
        self.measured_ns = -1
        """Time of the newest measurement; -1 before the first one."""

    @property
    def std(self) -> tuple[float, ...]:
        """Standard deviations of the offset, m and m/s."""
        return self._filter.std

    def reset(self) -> None:
        """Forget the offset, because an odometer that it refers to has begun anew."""
        self._filter.reset()
        self.measured_ns = -1

    def at(self, time_ns: int) -> Relative | None:
        """Return the offset at a time from `measured_ns` on; None before the first measurement."""
        if not self._filter.x:
            return None
        p, v = self._filter.x
        return Relative(p + v * ((time_ns - self.measured_ns) * NS), v)

    def state(self, time_ns: int, front: Odometer, rear: Odometer) -> Relative | None:
        """Return the state of the link at a time, by the odometers at that time."""
        if not self._filter.x:
            return None
        since_s = (time_ns - self.measured_ns) * NS
        return state_of(Relative(*self._filter.x), since_s, front, rear)

    def measure(self, time_ns: int, reading: Reading, front: Odometer) -> None:
        """Take in a radar reading of a time at which the odometer ahead is known."""
        assert reading.radar is not None
        periods = (time_ns - self.measured_ns) // self._period_ns
        if periods > GIVE_UP_PERIODS:
            self._filter.reset()
        expected = self.state(time_ns, front, reading.odometer)
        inputs = () if expected is None else (0.0,) * periods
        gap = (expected or reading.radar).p
        variances = (self._gap_error.variance(gap), self._speed_error.variance(reading.speed))
        measured = offset_of(reading.radar, front, reading.odometer)
        self._filter.step(inputs, measured, variances)
        self.measured_ns = time_ns
