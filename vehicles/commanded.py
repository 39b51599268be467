"""The acceleration that a vehicle expects of itself, from its commands and its actuator."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Final

from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.steps import NS, Number

# How a plan follows the last command: 3 time constants in steps of a quarter, then the command.
STEPS: Final = 12
_PER_LAG: Final = 4


def step_ns(lag_s: float) -> int:
    """Return the length of a step with which a plan follows the last command, ns."""
    return round(lag_s / _PER_LAG / NS)


def followed(
    a: Number, command: Number, lag_s: Number, dt: Number, decay: Number
) -> tuple[Number, Number]:
    """Return acceleration (m/s²) and change of speed (m/s) after dt (s) from acceleration a on.

    decay is e^(-dt / lag_s). All of them are floats or arrays.
    """
    return (
        command + (a - command) * decay,
        command * dt + (a - command) * lag_s * (1.0 - decay),
    )


class Commanded(Motion):
    """Commands that take effect at once."""

    __slots__ = ()

    def __init__(self, keep_ns: int) -> None:
        super().__init__(keep_ns)
        self.learn(0, 0, 0.0, (), ())

    def command(self, effective_ns: int, acceleration: float) -> None:
        """Take in a command; it replaces those that take effect later."""
        self.learn(effective_ns, effective_ns, acceleration, (), ())

    def restart(self, time_ns: int, acceleration: float) -> None:
        """Ignore that the vehicle does something else: the next command counts all the same."""


class LaggedCommands:
    """Commands that an actuator follows with a first-order lag (`world.actuators`).

    Queries must be in order of time: `steps_from` and `restart` forget everything before.
    """

    def __init__(self, lag_s: float) -> None:
        self._lag_s = lag_s
        self._step_ns = step_ns(lag_s)
        self._start_ns, self._start = 0, 0.0  # acceleration at an instant
        self._from_ns, self._command = [0], [0.0]

    def command(self, effective_ns: int, acceleration: float) -> None:
        """Take in a command; it replaces those that take effect later."""
        while self._from_ns and self._from_ns[-1] >= effective_ns:
            self._from_ns.pop()
            self._command.pop()
        self._from_ns.append(effective_ns)
        self._command.append(acceleration)

    def restart(self, time_ns: int, acceleration: float) -> None:
        """Set the acceleration at an instant, m/s²."""
        self._start_ns, self._start = time_ns, acceleration
        while len(self._from_ns) > 1 and self._from_ns[1] <= time_ns:
            del self._from_ns[0], self._command[0]

    def mean(self, t0_ns: int, t1_ns: int) -> float:
        """Return the mean acceleration from t0 to t1, m/s²."""
        at_t0, _ = self._over(self._start_ns, t0_ns, self._start)
        _, dv = self._over(t0_ns, t1_ns, at_t0)
        return dv / ((t1_ns - t0_ns) * NS)

    def steps_from(self, time_ns: int) -> tuple[list[int], list[float]]:
        """Return mean accelerations from `time_ns` on, as steps: times (ns), values (m/s²)."""
        a, _ = self._over(self._start_ns, time_ns, self._start)
        self.restart(time_ns, a)
        times = [time_ns, *(t for t in self._from_ns if t > time_ns)]
        last_ns = times[-1]
        times += [last_ns + number * self._step_ns for number in range(1, STEPS + 1)]
        values = []
        for t0_ns, t1_ns in pairwise(times):
            a, dv = self._over(t0_ns, t1_ns, a)
            values.append(dv / ((t1_ns - t0_ns) * NS))
        return times, [*values, self._command[-1]]

    def _over(self, t0_ns: int, t1_ns: int, a: float) -> tuple[float, float]:
        """Return acceleration at t1 (m/s²) and change of speed (m/s) since t0, when it was `a`."""
        dv, now_ns, last = 0.0, t0_ns, len(self._from_ns) - 1
        for at, command in enumerate(self._command):
            until_ns = t1_ns if at == last else min(self._from_ns[at + 1], t1_ns)
            if until_ns <= now_ns:
                continue
            dt = (until_ns - now_ns) * NS
            a, change = followed(a, command, self._lag_s, dt, math.exp(-dt / self._lag_s))
            dv += change
            now_ns = until_ns
        return a, dv


def commanded(lag_s: float, keep_ns: int) -> Commanded | LaggedCommands:
    """Return the expected motion of a vehicle; lag_s: time constant of its actuator, s; 0: none."""
    return LaggedCommands(lag_s) if lag_s else Commanded(keep_ns)
