"""The odometers of many vehicles: the own ones, and those of others, as beacons report them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from zenvoy.laws import Relative
from zenvoy.vehicles.arrays.beacons import Link
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.plans import Plan, Stretch
from zenvoy.vehicles.arrays.rows import ALL, Floats, Rows, chosen
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.odometer import Odometer, coasted, moved
from zenvoy.vehicles.steps import NS, steady


class OwnOdometers:
    """The odometers of `count` vehicles, from cycle 0 on."""

    def __init__(self, timing: Timing, own: OwnMotion, count: int) -> None:
        self._timing, self._own = timing, own
        self.now = Odometer(np.zeros(count), np.zeros(count))
        """The odometers at the start of the newest cycle."""

    def advance(self, acceleration: Floats) -> None:
        """Advance to the start of the next cycle with its readings, m/s²."""
        dt_s = self._timing.period_ns * NS
        self.now = moved(self.now, dt_s, steady(acceleration, dt_s))

    def at_effect(self, cycle: int) -> Odometer:
        """Return the odometers when the commands of the newest cycle take effect."""
        until_ns = self._timing.effect_ns
        return moved(self.now, until_ns * NS, self._own.over(cycle, until_ns, ALL))


class Heard(NamedTuple):
    """What beacons of one cycle say of odometers: at its start, and when its commands take effect.

    plan is the plan in between.
    """

    start: Odometer
    effect: Odometer
    plan: Plan

    def after(self, timing: Timing, cycles: int) -> Odometer:
        """Return the odometers some cycles later, as `Reckoned.at` does."""
        time_ns = cycles * timing.period_ns
        if time_ns >= timing.effect_ns:
            return coasted(self.effect, (time_ns - timing.effect_ns) * NS)
        if cycles == 0:
            return self.start
        return moved(
            self.start, time_ns * NS, self.plan.over(timing.starts_ns, Stretch(0, time_ns))
        )

    def of(self, rows: Rows) -> Heard:
        """Return what the beacons of some vehicles say."""
        return Heard(picked(self.start, rows), picked(self.effect, rows), self.plan.of(rows))


class ReckonedOdometers:
    """The odometers at the other ends of links, as `reckoned.Reckoned` has them."""

    def __init__(self, timing: Timing, link: Link) -> None:
        self._timing, self._link = timing, link
        start, effect = np.zeros((2, 2, len(link.sender)))
        self._start, self._effect = Odometer(*start), Odometer(*effect)

    def hear(self, rows: Rows, odometer: Odometer, plan: Plan) -> Heard:
        """Store the odometers and plans in beacons that the link has just heard; return them."""
        effect_ns = self._timing.effect_ns
        effect = moved(
            odometer, effect_ns * NS, plan.over(self._timing.starts_ns, Stretch(0, effect_ns))
        )
        self._start = _put(self._start, rows, odometer)
        self._effect = _put(self._effect, rows, effect)
        return Heard(odometer, effect, plan)

    def at(self, cycle: int) -> Odometer:
        """Return the odometers at the start of a cycle; 0 if nothing is heard yet."""
        timing, link = self._timing, self._link
        ages = cycle - link.cycle
        beyond_ns = ages * timing.period_ns - timing.effect_ns
        p, v = coasted(self._effect, beyond_ns * NS)
        found = Odometer(p, v.copy())  # v is still that of the effect
        for age in range(-(-timing.effect_ns // timing.period_ns)):
            rows = chosen((ages == age) & (link.cycle >= 0))
            if rows is not None:
                heard = Heard(self._start, self._effect, link.newest.plan).of(rows)
                found = _put(found, rows, heard.after(timing, age))
        return found

    def at_effect(self, cycle: int) -> Odometer:
        """Return the odometers when the commands of a cycle take effect."""
        return coasted(self._effect, self._link.age_ns(cycle) * NS)


def picked(odometer: Odometer, rows: Rows) -> Odometer:
    """Return the odometers of some vehicles."""
    return Odometer(odometer.p[rows], odometer.v[rows])


def relative(state: Relative, rows: Rows) -> Relative:
    """Return the relative states of some links."""
    return Relative(state.p[rows], state.v[rows])


def _put(odometers: Odometer, rows: Rows, some: Odometer) -> Odometer:
    """Return odometers with those of some vehicles replaced; the old arrays may change."""
    if isinstance(rows, slice):
        return some
    odometers.p[rows], odometers.v[rows] = some
    return odometers
