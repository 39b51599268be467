"""The own motion of vehicles: past readings, and commands that have not yet taken effect."""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.plans import Plan
from zenvoy.vehicles.arrays.rows import Floats, Rows, anywhere
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.knowledge import CONTRADICTS
from zenvoy.vehicles.steps import NS, over, spans


class OwnMotion:
    """The own motion of `count` vehicles. Call `sense`, then `command`, in each cycle from 0."""

    def __init__(self, timing: Timing, count: int) -> None:
        self._timing = timing
        self._nothing = np.zeros(count)
        self._read: list[Floats] = []  # by cycle: the mean over the period before it
        self._commands: list[Floats] = []
        self.plan = Plan(())
        """The plan of the newest cycle."""
        self.newest_command = self._nothing
        """The newest commands, or the readings where they contradict the commands, m/s²."""
        period_ns, lag = timing.period_ns, timing.lag
        # The commands in force over the last period: by cycles before the newest one.
        ages = (lag + 1, lag)
        starts_ns = [timing.effect_ns - age * period_ns for age in ages]
        parts = spans(starts_ns, -period_ns, 0)
        self._in_force = [(dt, ages[at]) for dt, at in parts]

    @property
    def cycle(self) -> int:
        """The newest cycle."""
        return len(self._read) - 1

    def sense(self, acceleration: Floats) -> Plan:
        """Store the readings at the start of the next cycle, m/s², and return the plan from there.

        The plan has the commands, or the reading where it contradicts them, as in
        `Knowledge.sense`.
        """
        self._read.append(acceleration)
        cycle = self.cycle
        values = [self._command_of(cycle - self._timing.lag)]
        values += [self._command_of(cycle - age) for age in range(self._timing.lag - 1, 0, -1)]
        commanded = [(dt, self._command_of(cycle - age)) for dt, age in self._in_force]
        _, dv = over([(dt, at) for at, (dt, _) in enumerate(commanded)], [a for _, a in commanded])
        apart = np.abs(acceleration - dv / (self._timing.period_ns * NS)) > CONTRADICTS
        bare = None
        self.newest_command = self._command_of(cycle - 1)
        if anywhere(apart):
            self.newest_command = np.where(apart, acceleration, self.newest_command)
            values[0] = np.where(apart, acceleration, values[0])
            bare = apart if len(values) > 1 else None
        self.plan = Plan(tuple(values), bare)
        return self.plan

    def command(self, acceleration: Floats) -> None:
        """Store the commands of the newest cycle."""
        self._commands.append(acceleration)

    def mean(self, cycle: int, rows: Rows) -> Floats:
        """Return the mean acceleration of some vehicles over the period from t_cycle, m/s²."""
        read = self._read[max(cycle, self._first_kept()) + 1][rows]
        if cycle == self.cycle - 1:
            return read
        period_s = self._timing.period_ns * NS
        return np.asarray(read * period_s / period_s)

    def over(self, cycle: int, until_ns: int, rows: Rows) -> tuple[Floats, Floats]:
        """Return displacement (m) and change of speed (m/s) from t_cycle to `until_ns`.

        `until_ns` counts from the start of the newest cycle, and is not before it.
        """
        timing, newest = self._timing, self.cycle
        plan = self.plan.of(rows)
        if cycle == newest:
            return plan.over(timing, 0, until_ns)
        first = self._first_kept()
        kept = range(first, newest)
        past_ns = [(j - newest) * timing.period_ns for j in kept]
        past = [self._read[j + 1][rows] for j in kept]
        t0_ns = (cycle - newest) * timing.period_ns
        dp, dv = over(spans((*past_ns, *timing.starts_ns), t0_ns, until_ns), (*past, *plan.values))
        if plan.bare is not None:
            bare_dp, bare_dv = over(spans((*past_ns, 0), t0_ns, until_ns), (*past, plan.values[0]))
            dp, dv = np.where(plan.bare, bare_dp, dp), np.where(plan.bare, bare_dv, dv)
        return dp, dv

    def _command_of(self, cycle: int) -> Floats:
        return self._commands[cycle] if cycle >= 0 else self._nothing

    def _first_kept(self) -> int:
        """Return the cycle at which the first period with a remembered reading begins."""
        timing = self._timing
        return max(-1, self.cycle - timing.keep_ns // timing.period_ns - 1)
