"""The accelerations that vehicles plan from the start of a cycle: commands not yet in effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

import numpy as np

from zenvoy.vehicles.arrays.lags import Lagged
from zenvoy.vehicles.arrays.rows import Bools, Floats, Rows, chosen
from zenvoy.vehicles.steps import NS, over, spans

Steps = Callable[[int], Sequence[Floats]]


class Past(NamedTuple):
    """Mean accelerations of past periods, m/s², and when these began; all of them end at a plan."""

    starts_ns: tuple[int, ...] = ()
    values: tuple[Floats, ...] = ()


NO_PAST: Final = Past()


class Stretch(NamedTuple):
    """A stretch of time from t0 to t1, ns, and what is known of the time before a plan.

    Times count from the start of the plan's cycle. Steps that end before oldest_ns are forgotten,
    and the first remaining one also holds before its time.
    """

    t0_ns: int
    t1_ns: int
    past: Past = NO_PAST
    oldest_ns: int | None = None

    def over(self, starts_ns: Sequence[int], steps: Steps) -> tuple[Floats, Floats]:
        """Return displacement beyond uniform motion (m) and change of speed (m/s).

        steps(last) returns the values, m/s², of the steps that begin at starts_ns, up to number
        `last`.
        """
        first, past = 0, self.past
        if self.oldest_ns is not None:
            while first + 1 < len(starts_ns) and starts_ns[first + 1] < self.oldest_ns:
                first += 1
        parts = spans((*past.starts_ns, *starts_ns[first:]), self.t0_ns, self.t1_ns)
        last = parts[-1][1] - len(past.starts_ns) + first if parts else 0
        return over(parts, (*past.values, *steps(last)[first:]))


class Plan(NamedTuple):
    """The accelerations in force from each of the `starts_ns` of a Timing, m/s².

    bare is a mask of the vehicles for which only the first entry counts, because the reading
    contradicts the commands; None means no vehicle. lagged says how the plans of vehicles with a
    lag go on; None means that no vehicle has one.
    """

    values: tuple[Floats, ...]
    bare: Bools | None = None
    lagged: Lagged | None = None

    def of(self, rows: Rows) -> Plan:
        """Return the plans of some vehicles."""
        if isinstance(rows, slice):
            return self
        values = tuple(value[rows] for value in self.values)
        bare = None if self.bare is None else self.bare[rows]
        return Plan(values, bare, None if self.lagged is None else self.lagged.of(rows))

    def over(self, starts_ns: Sequence[int], stretch: Stretch) -> tuple[Floats, Floats]:
        """Return displacement beyond uniform motion (m) and change of speed (m/s).

        starts_ns are those of plans without a lag, from the start of their cycle.
        """
        if self.lagged is None:
            dp, dv = stretch.over(starts_ns, lambda _: self.values)
        else:
            dp, dv = self._by_shape(self.lagged, stretch)
        if self.bare is not None:
            bare_dp, bare_dv = stretch.over((0,), lambda _: self.values[:1])
            dp = np.where(self.bare, bare_dp, dp)
            dv = np.where(self.bare, bare_dv, dv)
        return dp, dv

    def mean(self, starts_ns: Sequence[int], stretch: Stretch) -> Floats:
        """Return the mean acceleration, m/s²."""
        _, dv = self.over(starts_ns, stretch)
        return np.asarray(dv / ((stretch.t1_ns - stretch.t0_ns) * NS))

    def put(self, rows: Rows, of: Plan, count: int) -> Plan:
        """Return this plan of `count` vehicles with the entries of some of them replaced."""
        if isinstance(rows, slice) or not of.values:  # without entries there is nothing to replace
            return of
        plan = self if self.values else _no_plan(of, count)
        for value, new in zip(plan.values, of.values, strict=True):
            value[rows] = new
        if plan.lagged is not None and of.lagged is not None:
            plan.lagged.put(rows, of.lagged)
        bare = plan.bare
        if of.bare is not None or bare is not None:
            bare = np.zeros(count, dtype=np.bool_) if bare is None else bare
            bare[rows] = False if of.bare is None else of.bare
        return plan._replace(bare=bare)

    def _by_shape(self, lagged: Lagged, stretch: Stretch) -> tuple[Floats, Floats]:
        """Return what `over` does, one shape of plans after the other."""
        which, past = lagged.which, stretch.past
        dp, dv = np.empty((2, len(which)))
        for number in np.unique(which).tolist():
            shape = lagged.shapes[number]
            rows = chosen(which == number)
            if rows is None or isinstance(rows, slice):  # all of them have this shape
                return stretch.over(shape.starts_ns, partial(lagged.steps, shape, self.values))
            values = tuple(value[rows] for value in self.values)
            some = Past(past.starts_ns, tuple(value[rows] for value in past.values))
            dp[rows], dv[rows] = stretch._replace(past=some).over(
                shape.starts_ns, partial(lagged.of(rows).steps, shape, values)
            )
        return dp, dv


def _no_plan(like: Plan, count: int) -> Plan:
    """Return a plan of `count` vehicles in which all accelerations are 0."""
    lagged = like.lagged
    if lagged is not None:
        zeros, which = np.zeros((2, count)), np.zeros(count, dtype=np.int64)
        lagged = Lagged(lagged.shapes, which, zeros[0], zeros[1])
    return Plan(tuple(np.zeros(count) for _ in like.values), None, lagged)
