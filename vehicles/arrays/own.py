"""The own motion of vehicles: past readings, and commands that have not yet taken effect."""

from __future__ import annotations

import numpy as np

from zenvoy.vehicles.arrays.lags import Actuators
from zenvoy.vehicles.arrays.plans import Past, Plan, Stretch
from zenvoy.vehicles.arrays.rows import Floats, Rows, anywhere
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.knowledge import CONTRADICTS
from zenvoy.vehicles.steps import NS, over, spans


class OwnMotion:
    """The own motion of vehicles. Call `sense`, then `command`, in each cycle from 0.

    lag_s has the time constants of their actuators, (count,), s; 0: none. If no law `predicts`,
    plans hold only the acceleration in force.
    """

    def __init__(self, timing: Timing, lag_s: Floats, *, predicts: bool) -> None:
        self._timing, self._predicts = timing, predicts
        self._actuators = Actuators(timing, lag_s) if anywhere(lag_s > 0.0) else None
        self._nothing = np.zeros(len(lag_s))
        self._read: dict[int, Floats] = {}  # by cycle: the mean over the period before it
        self._commands: dict[int, Floats] = {}
        self.cycle = -1
        """The newest cycle."""
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

    def sense(self, acceleration: Floats) -> Plan:
        """Store the readings at the start of the next cycle, m/s², and return the plan from there.

        The plan has the commands, or the reading where it contradicts them, as in
        `Knowledge.sense`.
        """
        self.cycle += 1
        self._read[self.cycle] = acceleration
        self._read.pop(self._first_kept(), None)
        plan, mean = self._at_once() if self._actuators is None else self._lagged(self._actuators)
        apart = np.abs(acceleration - mean) > CONTRADICTS
        self.newest_command = self._command_of(self.cycle - 1)
        if anywhere(apart):
            self.newest_command = np.where(apart, acceleration, self.newest_command)
            values = (np.where(apart, acceleration, plan.values[0]), *plan.values[1:])
            has_more = len(values) > 1 or plan.lagged is not None
            plan = plan._replace(values=values, bare=apart if has_more else None)
            if self._actuators is not None:
                self._actuators.restart(apart, acceleration)
        self.plan = plan
        return plan

    def command(self, acceleration: Floats) -> None:
        """Store the commands of the newest cycle."""
        self._commands[self.cycle] = acceleration
        self._commands.pop(self.cycle - self._timing.lag - 1, None)

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
            return plan.over(timing.starts_ns, Stretch(0, until_ns))
        kept = range(max(cycle, self._first_kept()), newest)  # nothing before t_cycle matters
        past = Past(
            tuple((j - newest) * timing.period_ns for j in kept),
            tuple(self._read[j + 1][rows] for j in kept),
        )
        known = self._known
        if plan.lagged is None:  # at first it has steps of 0 before those of known commands
            values = (plan.values[0], *plan.values[timing.lag - known + 1 :])
            plan = plan._replace(values=values)
        stretch = Stretch((cycle - newest) * timing.period_ns, until_ns, past)
        return plan.over(timing.starts_of(known), stretch)

    def _at_once(self) -> tuple[Plan, Floats]:
        """Return the plan without a lag, and the mean acceleration over the last period, m/s²."""
        cycle, lag = self.cycle, self._timing.lag
        ages = range(lag, 0, -1) if self._predicts else (lag,)
        commanded = [(dt, self._command_of(cycle - age)) for dt, age in self._in_force]
        _, dv = over([(dt, at) for at, (dt, _) in enumerate(commanded)], [a for _, a in commanded])
        values = tuple(self._command_of(cycle - age) for age in ages)
        return Plan(values), dv / (self._timing.period_ns * NS)

    def _lagged(self, actuators: Actuators) -> tuple[Plan, Floats]:
        """Return plan and mean acceleration where some vehicles have a lag."""
        cycle, lag = self.cycle, self._timing.lag
        _, mean = self._at_once()
        period_s = self._timing.period_ns * NS
        # Until the first command takes effect, no command is in force, and nothing changes.
        in_force = self._in_force if cycle >= lag else [(period_s, cycle + 1)]
        dv = actuators.advance([(dt, self._command_of(cycle - age)) for dt, age in in_force])
        mean = actuators.chosen(dv / period_s, mean)
        commands = [self._command_of(cycle - age) for age in range(self._known, 0, -1)]
        if not self._predicts:
            return Plan((actuators.in_force(commands),)), mean
        values, lagged = actuators.plan(commands)
        return Plan(values, lagged=lagged), mean

    @property
    def _known(self) -> int:
        """The number of steps of the newest plan that have a command, or none before the first."""
        return min(self.cycle + 1, self._timing.lag)

    def _command_of(self, cycle: int) -> Floats:
        return self._commands[cycle] if cycle >= 0 else self._nothing

    def _first_kept(self) -> int:
        """Return the cycle at which the first period with a remembered reading begins."""
        timing = self._timing
        return max(-1, self.cycle - timing.keep_ns // timing.period_ns - 1)
