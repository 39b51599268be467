"""What the vehicles know: their readings, the beacons they received, and estimates from both.

`vehicles.knowledge` does the same for one vehicle.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import numpy as np

from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.filters import LinkFilters
from zenvoy.vehicles.arrays.links import Links, gap_then
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.plans import Plan, Stretch
from zenvoy.vehicles.arrays.plans_ahead import PlansAhead
from zenvoy.vehicles.arrays.refusal import NotCoveredError
from zenvoy.vehicles.arrays.rows import ALL, Bools, Floats, Ints, Rows, chosen, everywhere, within
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.view import Known
from zenvoy.vehicles.link_errors import link_errors
from zenvoy.vehicles.state import GIVE_UP_PERIODS, predicted
from zenvoy.vehicles.steps import NS

Accelerations = Callable[[int, Rows], Floats]
"""A function that returns mean accelerations (m/s²) of some vehicles over a past period.

The period begins the given number of cycles ago.
"""


class Estimators:
    """The filters of every vehicle for its link ahead and its link behind.

    With `by_position`, reported positions measure the links instead of radars.
    """

    def __init__(
        self,
        scenario: Scenario,
        timing: Timing,
        own: OwnMotion,
        links: Links,
        *,
        by_position: bool,
    ) -> None:
        self._ahead, self._behind = links.ahead[0], links.behind[0]
        self._seams = links.seam_ahead[0], links.seam_behind[0]
        count = len(self._ahead.sender)
        period_s, sigma = timing.period_ns * 1e-9, scenario.estimator.acceleration_std_mps2
        gap_error, speed_error = link_errors(scenario)
        self._timing, self._own, self._by_position = timing, own, by_position
        self.link_ahead, self.link_behind = (
            LinkFilters(period_s, sigma, copy(gap_error), copy(speed_error), count)
            for _ in range(2)
        )
        self._plans = PlansAhead(links.ahead[0], timing)
        self._past: dict[int, tuple[Floats, Floats]] = {}  # own positions and speeds by cycle

    def sense(self, cycle: int, beacons: Beacons) -> None:
        """Store the own readings of a cycle, because late beacons are compared with them."""
        if self._by_position:
            self._past[cycle] = (beacons.position, beacons.speed)
            if len(self._past) > self._timing.keep_ns // self._timing.period_ns + 2:
                del self._past[next(iter(self._past))]

    def hear(self, link: Link, cycle: int, rows: Rows, beacons: Beacons) -> Beacons:
        """Store beacons of a cycle that a link has delivered, and measure the link by them.

        Return the beacons that each of the vehicles has heard.
        """
        measures = link is self._behind or (link is self._ahead and self._by_position)
        before, of_cycle = link.newest.plan, link.cycle
        known = self._plans.known(rows) if link is self._ahead else None
        if not isinstance(rows, slice) and measures:  # hearing changes the arrays in place
            before, of_cycle = before.of(rows), of_cycle[rows]
        heard = link.hear(cycle, rows, beacons)
        if link is self._ahead:
            self._plans.heard(rows)
        if not measures:
            return heard
        looks_back = link is self._behind
        own, timing = self._own, self._timing

        def relative(back: int, some: Rows) -> Floats:
            """Return the acceleration of the vehicle in front minus that of the one behind it."""
            at = cycle - back
            mine = own.mean(at, within(rows, some))
            if back == 1:
                theirs = heard.acceleration[some]
            else:
                theirs = _planned(timing, before.of(some), of_cycle[some], at, cycle)
                if known is not None:
                    period_s = timing.period_ns * NS
                    only = heard.acceleration[some] * period_s / period_s
                    theirs = np.where(known[some], theirs, only)
            return mine - theirs if looks_back else theirs - mine

        filters = self.link_behind if looks_back else self.link_ahead
        z = self._state_in(link, cycle, rows, heard)
        self._measure(filters, cycle, rows, z, heard.speed, relative)
        return heard

    def _state_in(
        self, link: Link, cycle: int, rows: Rows, heard: Beacons
    ) -> tuple[Floats, Floats]:
        if not self._by_position:
            return heard.gap, heard.relative_speed
        if cycle not in self._past:
            raise NotCoveredError(
                "a beacon that is older than what vehicles remember of themselves"
            )
        position, speed = (column[rows] for column in self._past[cycle])
        ahead = link is self._ahead
        seam = self._seams[0 if ahead else 1][rows]
        return gap_then(heard, position, speed, seam, ahead=ahead)

    def estimate(
        self, cycle: int, beacons: Beacons, radar: Rows, wanted: Bools | None
    ) -> tuple[Known, Known]:
        """Estimate at t_cycle, and return the links ahead and behind at the commands' effect.

        radar selects the vehicles with a vehicle ahead. wanted is a mask of those whose link behind
        is used; None means all of them.
        """
        self._plans.forget_old(cycle)
        acceleration = beacons.acceleration
        if not self._by_position:
            ahead = self._plans.last_mean(cycle)

            def relative(_back: int, some: Rows) -> Floats:
                which = within(radar, some)
                return ahead[which] - acceleration[which]

            z = (beacons.gap[radar], beacons.relative_speed[radar])
            self._measure(self.link_ahead, cycle, radar, z, beacons.speed[radar], relative)
        return self._predicted(cycle, wanted)

    def _predicted(self, cycle: int, wanted: Bools | None) -> tuple[Known, Known]:
        until_ns = self._timing.effect_ns
        own = self._own.over(cycle, until_ns, ALL)
        if self._by_position:
            ahead = self._predict_by_age(cycle, self.link_ahead, self._ahead, None)
        else:
            front, link = self._plans.over(cycle, until_ns), self.link_ahead
            state = predicted(link.p, link.v, until_ns * NS, front, own)
            ahead = Known(state, _measured(link))
        behind = self._predict_by_age(cycle, self.link_behind, self._behind, wanted)
        return ahead, behind

    def _predict_by_age(
        self, cycle: int, filters: LinkFilters, link: Link, wanted: Bools | None
    ) -> Known:
        """Predict links that beacons measure, each from its own newest measurement."""
        timing = self._timing
        until_ns, looks_back = timing.effect_ns, link is self._behind
        there = _measured(filters)
        which = there if wanted is None else wanted if there is None else there & wanted
        rows = ALL if which is None else chosen(which)
        count = len(filters.p)
        if rows is None:
            return Known(Relative(np.full(count, np.nan), np.full(count, np.nan)), there)
        ages = _by_age(cycle, filters.measured, rows)
        # Nobody uses the states that are left out.
        p, v = (np.empty(count) if which is None else np.full(count, np.nan) for _ in range(2))
        for age, members in ages.items():
            t1_ns = age * timing.period_ns + until_ns
            mine = self._own.over(cycle - age, until_ns, members)
            dp, dv = link.newest.plan.of(members).over(timing.starts_ns, Stretch(0, t1_ns))
            if not looks_back:
                known = self._plans.known(members)
                dp, dv = np.where(known, dp, 0.0), np.where(known, dv, 0.0)
            front, rear = (mine, (dp, dv)) if looks_back else ((dp, dv), mine)
            p[members], v[members] = predicted(
                filters.p[members], filters.v[members], t1_ns * NS, front, rear
            )
        return Known(Relative(p, v), there)

    def _measure(
        self,
        link: LinkFilters,
        cycle: int,
        rows: Rows,
        z: tuple[Floats, Floats],
        speed: Floats,
        relative: Accelerations,
    ) -> None:
        """Predict links to a cycle with their relative accelerations, and process readings z."""
        measured = link.measured[rows]
        periods = cycle - measured
        if everywhere(periods == 1) and cycle > 0:  # nearly always
            r = link.variances(rows, link.p[rows], speed)
            link.advance(rows, relative(1, ALL))
            link.correct(rows, cycle, 1, z, r)
            return
        started = measured >= 0
        goes_on = started & (periods <= GIVE_UP_PERIODS)
        r = link.variances(rows, np.where(goes_on, link.p[rows], z[0]), speed)
        if not goes_on.all():
            some = np.flatnonzero(~goes_on)
            link.start(within(rows, some), cycle, (z[0][some], z[1][some]), r[:, some])
        some = np.flatnonzero(goes_on)
        if not some.size:
            return
        for back in range(int(periods[some].max()), 0, -1):
            acting = some[periods[some] >= back]
            link.advance(within(rows, acting), relative(back, acting))
        link.correct(within(rows, some), cycle, periods[some], (z[0][some], z[1][some]), r[:, some])


def _measured(filters: LinkFilters) -> Bools | None:
    """Return which links have been measured; None means all of them."""
    return None if filters.started else filters.measured >= 0


def _by_age(cycle: int, measured: Ints, rows: Rows) -> dict[int, Rows]:
    """Return those of some links that have been measured, by cycles since the newest time."""
    ages = cycle - measured[rows]
    if ages.size and ages[0] <= cycle and everywhere(ages == ages[0]):
        return {int(ages[0]): rows}
    known: Bools = measured[rows] >= 0
    return {
        age: within(rows, np.flatnonzero(known & (ages == age)))
        for age in np.unique(ages[known]).tolist()
    }


def _planned(timing: Timing, plan: Plan, of_cycle: Ints, at: int, cycle: int) -> Floats:
    """Return mean accelerations over the period from t_at, by plans of the cycles `of_cycle`.

    `cycle` is the cycle of the beacon that has arrived since. Vehicles forget entries of a plan
    that are too old, and then the first remaining entry also holds before its time.
    """
    mean = np.empty(len(of_cycle))
    for begin in np.unique(of_cycle).tolist():
        rows = np.flatnonzero(of_cycle == begin)
        oldest_ns = (cycle - begin) * timing.period_ns - timing.keep_ns
        t0_ns = (at - begin) * timing.period_ns
        stretch = Stretch(t0_ns, t0_ns + timing.period_ns, oldest_ns=oldest_ns)
        mean[rows] = plan.of(rows).mean(timing.starts_ns, stretch)
    return mean
