"""Estimates of links that both ends of a link share; `vehicles.shared_links` is for one vehicle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link, Shared
from zenvoy.vehicles.arrays.links import Links
from zenvoy.vehicles.arrays.odometers import OwnOdometers, ReckonedOdometers, picked, relative
from zenvoy.vehicles.arrays.offsets import Offsets, Readings
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.rows import Floats, Ints, Rows, chosen, within
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.view import Known
from zenvoy.vehicles.estimator import advanced, corrected
from zenvoy.vehicles.link_errors import nominal_variances
from zenvoy.vehicles.odometer import Odometer, offset_of, state_of
from zenvoy.vehicles.shared_links import kept_cycles, known_cycles
from zenvoy.vehicles.steps import NS
from zenvoy.vehicles.unheard import unheard_gains


class Logged(NamedTuple):
    """The estimates of links as a log has them, and their cycles; -1 if there is no estimate.

    std returns the standard deviations of gap and relative speed, (2, count).
    """

    state: Relative
    measured: Ints
    std: Callable[[], Floats]


class SharedLinks:
    """The links of all vehicles. In each cycle call `sense`, then `hear`, then `predict`."""

    def __init__(self, scenario: Scenario, timing: Timing, own: OwnMotion, links: Links) -> None:
        self._timing = timing
        self._ahead, self._behind = links.ahead[0], links.behind[0]
        count = len(self._ahead.sender)
        self._has_radar = self._ahead.exists
        self._own = OwnOdometers(timing, own, count)
        self._front = ReckonedOdometers(timing, self._ahead)
        self._rear = ReckonedOdometers(timing, self._behind)
        self._offsets = Offsets(scenario, timing, count)
        gains = unheard_gains(timing.period_ns * NS, nominal_variances(scenario))
        self._gains = np.array(gains)
        self._kept, self._known = kept_cycles(timing.period_ns), known_cycles(scenario)
        self._past: dict[int, Readings] = {}
        self._stray = Relative(np.zeros(count), np.zeros(count))
        self._offset_behind = Relative(np.zeros(count), np.zeros(count))
        self.logged_behind = Logged(
            Relative(np.full(count, np.nan), np.full(count, np.nan)),
            np.full(count, -1, dtype=np.int64),
            lambda: np.full((2, count), np.nan),
        )
        """The estimates of the links behind at the time of the newest beacons."""

    def sense(self, cycle: int, beacons: Beacons) -> Shared:
        """Process the readings of a cycle, and return what its beacons report."""
        if cycle > 0:
            self._own.advance(beacons.acceleration)
        radar = Relative(beacons.gap, beacons.relative_speed)
        readings = Readings(self._own.now, radar, beacons.speed)
        self._past[cycle] = readings
        if len(self._past) > self._kept:
            del self._past[next(iter(self._past))]
        front, missed = self._front.at(cycle), self._missed(cycle)
        rows = chosen(self._has_radar & (missed == 0))
        if rows is not None:
            self._offsets.measure(rows, cycle, readings.of(rows), picked(front, rows))
        rows = chosen(self._has_radar & (missed > 0))
        if rows is not None:
            self._follow(rows, cycle, missed[rows], readings.of(rows), picked(front, rows))
        return Shared(self._own.now, self._offsets.at(cycle))

    def hear(self, link: Link, cycle: int, now: int, rows: Rows, heard: Beacons) -> None:
        """Process what beacons of a cycle report to some vehicles, `rows` of the link, in `now`."""
        report = heard.shared
        assert report is not None
        if link is self._behind:
            self._rear.hear(rows, report.odometer, heard.plan)
            self._store_behind(cycle, rows, report)
        if link is not self._ahead:
            return
        front = self._front.hear(rows, report.odometer, heard.plan)
        self._stray.p[rows], self._stray.v[rows] = 0.0, 0.0
        for at in range(cycle, min(now, cycle + self._known) + 1):
            new = chosen(self._offsets.measured[rows] < at)
            if new is not None and at in self._past:
                which = within(rows, new)
                then = front.of(new).after(self._timing, at - cycle)
                self._offsets.measure(which, at, self._past[at].of(which), then)

    def predict(self, cycle: int) -> tuple[Known, Known]:
        """Return the links ahead and behind when the commands of a cycle take effect."""
        effect_ns, own = self._timing.effect_ns, self._own.at_effect(cycle)
        since_s = (self._behind.age_ns(cycle) + effect_ns) * NS
        behind = state_of(self._offset_behind, since_s, own, self._rear.at_effect(cycle))
        ahead = self._ahead_at(cycle, effect_ns, self._front.at_effect(cycle), own)
        heard = self._behind.cycle >= 0
        return Known(ahead, self._offsets.known), Known(behind, None if heard.all() else heard)

    def behind_age_s(self, cycle: int) -> Floats:
        """Return the ages of what is known of the links behind; NaN for nothing."""
        return np.where(self._behind.cycle >= 0, self._behind.age_ns(cycle) * NS, np.nan)

    def logged_ahead(self, cycle: int) -> Logged:
        """Return the estimates of the links ahead at the start of a cycle."""
        state = self._ahead_at(cycle, 0, self._front.at(cycle), self._own.now)
        measured = np.where(self._offsets.measured >= 0, cycle, -1)
        return Logged(state, measured, self._offsets.std)

    def _missed(self, cycle: int) -> Ints:
        """Return for how many cycles the motion ahead has not been known."""
        heard = self._ahead.cycle
        return np.where(heard >= 0, np.maximum(0, cycle - heard - self._known), cycle)

    def _follow(
        self, rows: Rows, cycle: int, missed: Ints, readings: Readings, front: Odometer
    ) -> None:
        """Correct how far the vehicles ahead have strayed since their motion is not known."""
        offset = relative(self._offsets.at(cycle), rows)
        seen = offset_of(readings.radar, front, readings.odometer)
        p, v = advanced(*relative(self._stray, rows), 0.0, self._timing.period_ns * NS)
        gains = self._gains[np.minimum(missed, len(self._gains)) - 1]
        gain = [[gains[:, i, j] for j in range(2)] for i in range(2)]
        found = corrected(p, v, seen.p - offset.p, seen.v - offset.v, gain)
        self._stray.p[rows], self._stray.v[rows] = found

    def _store_behind(self, cycle: int, rows: Rows, report: Shared) -> None:
        self._offset_behind.p[rows], self._offset_behind.v[rows] = report.offset
        state, measured, _ = self.logged_behind
        then = self._past.get(cycle)
        if then is None:
            state.p[rows], state.v[rows], measured[rows] = np.nan, np.nan, -1
            return
        found = state_of(report.offset, 0.0, picked(then.odometer, rows), report.odometer)
        state.p[rows], state.v[rows] = found
        measured[rows] = cycle

    def _ahead_at(self, cycle: int, after_ns: int, front: Odometer, own: Odometer) -> Relative:
        state = self._offsets.state(cycle, after_ns, front, own)
        p, v = self._stray
        return Relative(state.p + (p + v * (after_ns * NS)), state.v + v)
