"""What vehicles expect of the vehicle ahead, by the plan in its newest beacon."""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.beacons import Link
from zenvoy.vehicles.arrays.plans import Stretch
from zenvoy.vehicles.arrays.rows import Bools, Floats, Rows
from zenvoy.vehicles.arrays.timing import Timing


class PlansAhead:
    """The plans of the vehicles ahead, which `link` delivers, as far as they are known."""

    def __init__(self, link: Link, timing: Timing) -> None:
        self._link, self._timing = link, timing
        self._known = np.zeros(len(link.sender), dtype=np.bool_)

    def known(self, rows: Rows) -> Bools:
        """Return a copy of which vehicles know a plan."""
        known: Bools = self._known[rows].copy()
        return known

    def heard(self, rows: Rows) -> None:
        """Note that vehicles have received a beacon of the vehicle ahead."""
        self._known[rows] = True

    def forget_old(self, cycle: int) -> None:
        """Forget plans that are too old; an old plan is worse than none."""
        if not self._link.all_of(cycle):
            self._known &= self._link.fresh(cycle)

    def last_mean(self, cycle: int) -> Floats:
        """Return mean accelerations over the last period, m/s²; 0 where no plan is known."""
        newest, timing = self._link.newest, self._timing
        if self._link.all_of(cycle):
            return newest.acceleration
        mean = np.zeros(len(self._link.sender))
        for age, rows in self._link.ages(cycle).items():
            if age == 0:
                mean[rows] = newest.acceleration[rows]
            else:
                t1_ns = age * timing.period_ns
                plan = newest.plan.of(rows)
                mean[rows] = plan.mean(timing.starts_ns, Stretch(t1_ns - timing.period_ns, t1_ns))
        mean[~self._known] = 0.0
        return mean

    def over(self, cycle: int, until_ns: int) -> tuple[Floats, Floats]:
        """Return displacement (m) and change of speed (m/s) in the `until_ns` after t_cycle."""
        newest, timing = self._link.newest, self._timing
        if self._link.all_of(cycle):
            return newest.plan.over(timing.starts_ns, Stretch(0, until_ns))
        dp, dv = (np.zeros(len(self._link.sender)) for _ in range(2))
        for age, rows in self._link.ages(cycle).items():
            t0_ns = age * timing.period_ns
            stretch = Stretch(t0_ns, t0_ns + until_ns)
            dp[rows], dv[rows] = newest.plan.of(rows).over(timing.starts_ns, stretch)
        dp[~self._known] = 0.0
        dv[~self._known] = 0.0
        return dp, dv
