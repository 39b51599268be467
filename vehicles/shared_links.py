"""Estimates of links that both ends of a link share (docs/beyond-the-paper.md).

The vehicle at the rear of a link estimates the link's offset (`odometer`) from its radar, and its
beacons carry the estimate. Both ends act on it, so their forces cancel as BCM wants it: noise of
the estimate moves them against each other, and not against the fleet. Beacons also carry odometers,
so that the first beacon after a burst of losses tells all that has happened in the meantime.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from zenvoy.laws import Relative
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.estimator import advanced, corrected
from zenvoy.vehicles.link_errors import nominal_variances
from zenvoy.vehicles.link_offset import LinkOffset, Reading
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.odometer import Odometer, moved, offset_of, state_of
from zenvoy.vehicles.received import ReceivedBeacon, Report
from zenvoy.vehicles.reckoned import Reckoned
from zenvoy.vehicles.steps import NS
from zenvoy.vehicles.unheard import unheard_gains

_KEPT_NS: Final = 2_000_000_000
_START: Final = Odometer(0.0, 0.0)
_NO_STRAY: Final = Relative(0.0, 0.0)


class LinkEstimate(NamedTuple):
    """The estimate of a link that is logged, at `measured_ns`, with its standard deviations."""

    estimate: Relative | None = None
    std: tuple[float, ...] = ()
    measured_ns: int = -1


class Behind(NamedTuple):
    """What is known of the link behind: the newest beacon there, and the offset that it carries."""

    odometer: Reckoned
    offset: Relative


class SharedLinks:
    """The links of one vehicle. Call `sense` in each cycle, then `hear` for each new beacon."""

    def __init__(self, scenario: Scenario, own: Motion) -> None:
        """`own`: the motion of the vehicle, which knows of its senses before this object."""
        self._own = own
        self._period_ns = scenario.period_ns
        self._effect_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
        self._known = known_cycles(scenario)
        self._kept = kept_cycles(scenario.period_ns)
        self._offset = LinkOffset(scenario)
        self._gains = unheard_gains(scenario.period_ns * NS, nominal_variances(scenario))
        self._odometer, self._since_ns, self._time_ns = _START, -1, -1
        self._past: dict[int, Reading] = {}
        self._ahead: Reckoned | None = None
        self._stray = _NO_STRAY  # of the vehicle ahead, from where it is reckoned to be
        self._behind: Behind | None = None
        self.behind = LinkEstimate()
        """The estimate of the link behind at the time of the newest beacon."""

    @property
    def ahead(self) -> LinkEstimate:
        """The estimate of the link ahead at the start of the cycle."""
        state = self._ahead_at(self._time_ns, self._odometer)
        return LinkEstimate(state, self._offset.std, self._time_ns) if state else LinkEstimate()

    @property
    def behind_age_s(self) -> float:
        """Age of what is known of the link behind at the start of the cycle, s; NaN for nothing."""
        if self._behind is None:
            return NAN
        return (self._time_ns - self._behind.odometer.time_ns) * NS

    def sense(self, time_ns: int, radar: Relative | None, speed: float) -> Report:
        """Take in the readings of a cycle, and return what the beacon of the cycle reports."""
        if self._since_ns < 0:
            self._since_ns = time_ns
        else:
            by = self._own.over(self._time_ns, time_ns)
            self._odometer = moved(self._odometer, (time_ns - self._time_ns) * NS, by)
        before_ns, self._time_ns = self._time_ns, time_ns
        reading = Reading(self._odometer, radar, speed)
        self._past[time_ns] = reading
        if len(self._past) > self._kept:
            del self._past[next(iter(self._past))]
        if radar is not None:
            self._take_in(reading, (time_ns - before_ns) // self._period_ns)
        offset = self._offset.at(time_ns)
        return Report(self._odometer, self._since_ns, offset, self._ahead_since_ns)

    def hear_ahead(self, beacon: ReceivedBeacon) -> None:
        """Take in a new beacon of the vehicle ahead."""
        report = beacon.report
        if report is None:
            return
        if report.since_ns != self._ahead_since_ns:
            self._offset.reset()
        self._ahead = Reckoned(beacon, report, self._effect_ns)
        self._stray = _NO_STRAY
        period_ns, newest_ns = self._period_ns, self._offset.measured_ns
        known_ns = min(self._time_ns, beacon.time_ns + self._known * period_ns)
        for time_ns in range(beacon.time_ns, known_ns + 1, period_ns):
            reading = self._past.get(time_ns)
            if time_ns > newest_ns and reading is not None and reading.radar is not None:
                self._offset.measure(time_ns, reading, self._ahead.at(time_ns))

    def hear_behind(self, beacon: ReceivedBeacon) -> None:
        """Take in a new beacon of the vehicle behind."""
        report, own = beacon.report, self._past.get(beacon.time_ns)
        if report is None or report.offset is None or report.ahead_since_ns != self._since_ns:
            return
        self._behind = Behind(Reckoned(beacon, report, self._effect_ns), report.offset)
        self.behind = LinkEstimate()
        if own is not None:
            state = state_of(report.offset, 0.0, own.odometer, report.odometer)
            self.behind = LinkEstimate(state, (), beacon.time_ns)

    def predict(self, until_ns: int) -> tuple[Relative | None, Relative | None]:
        """Return the states of the links ahead and behind at `until_ns`."""
        by = self._own.over(self._time_ns, until_ns)
        own = moved(self._odometer, (until_ns - self._time_ns) * NS, by)
        behind = None
        if self._behind is not None:
            rear, offset = self._behind
            since_s = (until_ns - rear.time_ns) * NS
            behind = state_of(offset, since_s, own, rear.at(until_ns))
        return self._ahead_at(until_ns, own), behind

    @property
    def _ahead_since_ns(self) -> int:
        """When the odometer ahead began; until it is heard, it counts as begun with the own one."""
        return self._since_ns if self._ahead is None else self._ahead.since_ns

    def _front(self, time_ns: int) -> Odometer:
        return _START if self._ahead is None else self._ahead.at(time_ns)

    def _missed(self, time_ns: int) -> int:
        """Return the number of cycles up to a time in which the motion ahead is not known."""
        if self._ahead is None:
            return (time_ns - self._since_ns) // self._period_ns
        return max(0, (time_ns - self._ahead.time_ns) // self._period_ns - self._known)

    def _take_in(self, reading: Reading, periods: int) -> None:
        """Take in the radar reading of this cycle, `periods` after the last one."""
        time_ns, missed = self._time_ns, self._missed(self._time_ns)
        front = self._front(time_ns)
        if not missed:
            self._offset.measure(time_ns, reading, front)
            return
        offset = self._offset.at(time_ns)
        if offset is None:
            return
        assert reading.radar is not None
        seen = offset_of(reading.radar, front, reading.odometer)
        p, v = self._stray
        for _ in range(periods):
            p, v = advanced(p, v, 0.0, self._period_ns * NS)
        gain = self._gains[min(missed, len(self._gains)) - 1]
        self._stray = Relative(*corrected(p, v, seen.p - offset.p, seen.v - offset.v, gain))

    def _ahead_at(self, time_ns: int, own: Odometer) -> Relative | None:
        state = self._offset.state(time_ns, self._front(time_ns), own)
        if state is None:
            return None
        p, v = self._stray
        return Relative(state.p + (p + v * ((time_ns - self._time_ns) * NS)), state.v + v)


def kept_cycles(period_ns: int) -> int:
    """Return for how many cycles a vehicle keeps its readings, which late beacons refer to."""
    return _KEPT_NS // period_ns + 2


def known_cycles(scenario: Scenario) -> int:
    """Return for how many cycles after a beacon the motion of its sender is known by its plan."""
    return max(1, (scenario.v2v_wait_ns + scenario.system_delay_ns) // scenario.period_ns)
