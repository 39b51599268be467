"""Actuators that follow their commands as a first-order lag, as `vehicles.commanded` has them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints, everywhere
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.commanded import STEPS, followed, step_ns
from zenvoy.vehicles.steps import NS


class Shape(NamedTuple):
    """When the steps of a plan begin, from the start of its cycle, and how many of them it stores.

    Those that follow the stored ones are of equal length step_s, with this decay; the last one,
    which has no end, is the newest command.
    """

    starts_ns: tuple[int, ...]
    stored: int
    lag_s: float = 0.0
    step_s: float = 1.0
    decay: float = 0.0


class Lagged(NamedTuple):
    """How plans go on after the steps that they store.

    which has the number of each plan's shape. acceleration is that at the end of the stored steps,
    and command is the newest one, in m/s².
    """

    shapes: Sequence[Shape]
    which: Ints
    acceleration: Floats
    command: Floats

    def of(self, rows: Ints) -> Lagged:
        """Return this for some vehicles."""
        return Lagged(self.shapes, self.which[rows], self.acceleration[rows], self.command[rows])

    def put(self, rows: Ints, of: Lagged) -> None:
        """Replace the entries of some vehicles."""
        self.which[rows], self.acceleration[rows] = of.which, of.acceleration
        self.command[rows] = of.command

    def steps(self, shape: Shape, stored: Sequence[Floats], last: int) -> list[Floats]:
        """Return the values of the steps up to number `last` of plans with this shape, m/s²."""
        values, a = list(stored[: shape.stored]), self.acceleration
        while len(values) <= last:
            if len(values) == len(shape.starts_ns) - 1:
                return [*values, self.command]
            a, dv = followed(a, self.command, shape.lag_s, shape.step_s, shape.decay)
            values.append(dv / shape.step_s)
        return values


class Actuators:
    """Actuators with time constants lag_s (count,), s; 0: a vehicle without a lag.

    The exponentials come from the C library, one for each time constant, as in `commanded`.
    """

    def __init__(self, timing: Timing, lag_s: Floats) -> None:
        self._timing, self._lagging = timing, lag_s > 0.0
        self._all_lag = everywhere(self._lagging)
        self._acceleration: Floats = np.zeros(len(lag_s))  # at the start of the newest cycle
        self._lag_s = np.where(self._lagging, lag_s, 1.0)  # nobody uses those of vehicles without
        distinct, self._class = np.unique(lag_s, return_inverse=True)
        self._distinct: list[float] = distinct.tolist()
        self._decays: dict[float, Floats] = {}
        shapes = [
            [_shape(timing.starts_of(known), lag) for known in range(1, timing.lag + 1)]
            for lag in self._distinct
        ]
        self._shapes = [shape for each in shapes for shape in each]
        self._step_s = self._each([each[0].step_s for each in shapes])
        self._step_decay = self._each([each[0].decay for each in shapes])

    def advance(self, in_force: Sequence[tuple[float, Floats]]) -> Floats:
        """Advance by a period, and return the changes of speed in it, m/s.

        in_force has the commands of the period, and for how long (s) each of them is in force.
        """
        a, dv = self._acceleration, np.zeros(len(self._lag_s))
        for dt, command in in_force:
            a, change = self._follow(a, command, dt)
            dv = dv + change
        self._acceleration = a
        return dv

    def restart(self, where: Bools, acceleration: Floats) -> None:
        """Store the accelerations of some vehicles at the start of the newest cycle, m/s²."""
        self._acceleration = np.where(where, acceleration, self._acceleration)

    def in_force(self, commands: Sequence[Floats]) -> Floats:
        """Return the accelerations of the first step, m/s²; see `plan`."""
        return self._steps(commands, 1)[0][0]

    def plan(self, commands: Sequence[Floats]) -> tuple[tuple[Floats, ...], Lagged]:
        """Return the accelerations in steps, and how they go on.

        commands are those from the one in force to the newest one. There are as many steps as if
        all commands were known; those that are too many have no meaning.
        """
        known, newest = len(commands), commands[-1]
        steps, a = self._steps(commands, known)
        which = self._class * self._timing.lag + known - 1
        spare = [newest] * (self._timing.lag - known)
        return (*steps, *spare), Lagged(self._shapes, which, a, newest)

    def chosen(self, lagging: Floats, at_once: Floats) -> Floats:
        """Return the value of each vehicle, by whether it has a lag."""
        return lagging if self._all_lag else np.where(self._lagging, lagging, at_once)

    def _steps(self, commands: Sequence[Floats], count: int) -> tuple[list[Floats], Floats]:
        """Return the accelerations of the first steps, and those at their end, m/s²."""
        a, steps = self._acceleration, []
        ends_ns = pairwise(self._timing.starts_of(len(commands)))
        for (t0_ns, t1_ns), command in zip(ends_ns, commands[:count], strict=False):
            dt = (t1_ns - t0_ns) * NS
            a, dv = self._follow(a, command, dt)
            steps.append(self.chosen(dv / dt, command))
        if len(steps) < count:  # the first one of those in which the newest command is in force
            newest = commands[-1]
            a, dv = followed(a, newest, self._lag_s, self._step_s, self._step_decay)
            steps.append(self.chosen(dv / self._step_s, newest))
        return steps, a

    def _follow(self, a: Floats, command: Floats, dt: float) -> tuple[Floats, Floats]:
        if dt not in self._decays:
            self._decays[dt] = self._each([_decay(dt, lag) for lag in self._distinct])
        return followed(a, command, self._lag_s, dt, self._decays[dt])

    def _each(self, values: list[float]) -> Floats:
        """Return values by time constant as values by vehicle."""
        return np.array(values)[self._class]


def _decay(dt: float, lag_s: float) -> float:
    return math.exp(-dt / lag_s) if lag_s else 0.0


def _shape(starts_ns: tuple[int, ...], lag_s: float) -> Shape:
    """Return the shape of plans with steps that begin at starts_ns, one for each command."""
    if not lag_s:
        return Shape(starts_ns, len(starts_ns))
    step = step_ns(lag_s)
    more = (starts_ns[-1] + number * step for number in range(1, STEPS + 1))
    return Shape((*starts_ns, *more), len(starts_ns), lag_s, step * NS, _decay(step * NS, lag_s))
