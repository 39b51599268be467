"""The beacons of a cycle, and the newest beacon that each vehicle has received on a link."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws import Relative
from zenvoy.vehicles.arrays.plans import Plan
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints, Rows
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.odometer import Odometer


class Shared(NamedTuple):
    """The part of the beacons of a cycle for laws that share links, as `received.Report`."""

    odometer: Odometer
    offset: Relative

    def of(self, senders: NDArray[np.int64]) -> Shared:
        """Return the parts of the beacons of some vehicles."""
        (p, v), (gap, speed) = self.odometer, self.offset
        return Shared(Odometer(p[senders], v[senders]), Relative(gap[senders], speed[senders]))


class Beacons(NamedTuple):
    """The beacons of a cycle: readings in m, m/s and m/s², plans, and newest commands in m/s².

    command is None unless a law of the fleet needs commands, and shared unless one shares links.
    """

    position: Floats
    speed: Floats
    acceleration: Floats
    gap: Floats
    relative_speed: Floats
    plan: Plan
    command: Floats | None = None
    shared: Shared | None = None

    def of(self, senders: NDArray[np.int64]) -> Beacons:
        """Return the beacons of some vehicles."""
        return Beacons(
            self.position[senders],
            self.speed[senders],
            self.acceleration[senders],
            self.gap[senders],
            self.relative_speed[senders],
            self.plan.of(senders),
            None if self.command is None else self.command[senders],
            None if self.shared is None else self.shared.of(senders),
        )


class Link:
    """A link from one vehicle to each of `count` vehicles, with the newest beacon received on it.

    It does not keep the part of the beacon for laws that share links (`SharedLinks.hear`).

    sender (count,) is the index of the vehicle that sends; -1 if there is none.
    """

    def __init__(self, timing: Timing, sender: Ints) -> None:
        count = len(sender)
        self._timing = timing
        self.sender = sender
        self.exists: Bools = sender >= 0
        self.cycle = np.full(count, -1, dtype=np.int64)
        """Cycle of the newest beacon; -1 if there is none yet."""
        position, speed, acceleration, gap, relative_speed = np.zeros((5, count))
        self.newest = Beacons(position, speed, acceleration, gap, relative_speed, Plan(()))
        self._uniform: int | None = None  # the cycle of every newest beacon, if it is the same
        self._everywhere = bool(self.exists.all())

    @property
    def reaches_all(self) -> bool:
        """Whether beacons for every receiver are news to every receiver."""
        return self._everywhere and self._uniform is not None

    def hear(self, cycle: int, rows: Rows, beacons: Beacons) -> Beacons:
        """Store the beacons of a cycle for some vehicles, to which they are news; return them."""
        heard = beacons.of(self.sender[rows])
        if isinstance(rows, slice):
            self.newest, self._uniform = heard._replace(shared=None), cycle
            self.cycle = np.full(len(self.sender), cycle)
        else:
            newest, count = self.newest, len(self.sender)
            for column, new in zip(newest[:5], heard[:5], strict=True):
                column[rows] = new
            self.newest = newest._replace(
                plan=newest.plan.put(rows, heard.plan, count),
                command=_put(newest.command, rows, heard.command, count),
            )
            self.cycle[rows], self._uniform = cycle, None
        return heard

    def all_of(self, cycle: int) -> bool:
        """Return whether every newest beacon is of this cycle."""
        return self._uniform == cycle

    def fresh(self, cycle: int) -> Bools:
        """Return where the newest beacon is young enough to be used in a cycle."""
        return (self.cycle >= 0) & (self.age_ns(cycle) <= self._timing.age_limit_ns)

    def age_ns(self, cycle: int) -> Ints:
        """Return the age of the newest beacon at the start of a cycle, where there is one."""
        return (cycle - self.cycle) * self._timing.period_ns

    def ages(self, cycle: int) -> dict[int, Rows]:
        """Return the links by age of their newest beacon in a cycle, in cycles."""
        if self._uniform is not None:
            return {cycle - self._uniform: slice(None)}
        ages = cycle - self.cycle
        heard = self.cycle >= 0
        return {
            age: np.flatnonzero(heard & (ages == age)) for age in np.unique(ages[heard]).tolist()
        }


def _put(known: Floats | None, rows: Rows, new: Floats | None, count: int) -> Floats | None:
    """Return the commands that are known, with those of some links replaced."""
    if new is None:
        return None
    known = np.zeros(count) if known is None else known
    known[rows] = new
    return known
