"""The accelerations that vehicles plan from the start of a cycle: commands not yet in effect."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from zenvoy.vehicles.arrays.rows import Bools, Floats, Rows
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.steps import NS, over, spans


class Plan(NamedTuple):
    """The accelerations in force from each of the `starts_ns` of a Timing, m/s².

    bare is a mask of the vehicles for which only the first entry counts, because the reading
    contradicts the commands; None means no vehicle.
    """

    values: tuple[Floats, ...]
    bare: Bools | None = None

    def of(self, rows: Rows) -> Plan:
        """Return the plans of some vehicles."""
        if isinstance(rows, slice):
            return self
        values = tuple(value[rows] for value in self.values)
        return Plan(values, None if self.bare is None else self.bare[rows])

    def over(self, timing: Timing, t0_ns: int, t1_ns: int, first: int = 0) -> tuple[Floats, Floats]:
        """Return displacement beyond uniform motion (m) and change of speed (m/s).

        The times t0 and t1 count from the start of the plan's cycle. Entries before
        `first` are forgotten.
        """
        values = self.values
        parts = spans(timing.starts_ns[first:], t0_ns, t1_ns)
        dp, dv = over(parts, values[first:])
        if self.bare is not None:
            bare_dp, bare_dv = over([((t1_ns - t0_ns) * NS, 0)], values)
            dp = np.where(self.bare, bare_dp, dp)
            dv = np.where(self.bare, bare_dv, dv)
        return dp, dv

    def mean(self, timing: Timing, t0_ns: int, t1_ns: int, first: int = 0) -> Floats:
        """Return the mean acceleration from t0 to t1, m/s²."""
        _, dv = self.over(timing, t0_ns, t1_ns, first)
        return np.asarray(dv / ((t1_ns - t0_ns) * NS))

    def put(self, rows: Rows, of: Plan) -> Plan:
        """Return this plan with the entries of some vehicles replaced."""
        if isinstance(rows, slice) or not of.values:  # without entries there is nothing to replace
            return of
        for value, new in zip(self.values, of.values, strict=True):
            value[rows] = new
        bare = self.bare
        if of.bare is not None or bare is not None:
            bare = np.zeros(self.values[0].shape, dtype=np.bool_) if bare is None else bare
            bare[rows] = False if of.bare is None else of.bare
        return Plan(self.values, bare)


def no_plan(timing: Timing, count: int) -> Plan:
    """Return a plan of `count` vehicles in which all accelerations are 0."""
    return Plan(tuple(np.zeros(count) for _ in timing.starts_ns))
