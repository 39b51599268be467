"""Drives one vehicle behind a recorded one by the record of a law.

The timing is that of a scenario: the law decides with the state at the start of a cycle, and the
command takes effect after the wait for frames and the delay of the system. This module repeats the
world's motion for a single pair, because a fit needs thousands of runs; a test compares it with a
run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws import Law, Observation, Output, Relative, Setpoint
from zenvoy.laws.errors import raised
from zenvoy.scenarios import Scenario, roster
from zenvoy.scenarios.convoys.convoy import Convoy

Floats = NDArray[np.float64]

_MIDDLE = 0.5  # every random number of a law, because a fit needs the same ones each time


class Timing(NamedTuple):
    """Length of a cycle and delay of a command (ns), limits of commands (m/s²), length (m)."""

    period_ns: int
    delay_ns: int
    lowest_mps2: float
    highest_mps2: float
    length_m: float

    @classmethod
    def of(cls, scenario: Scenario) -> Timing:
        """Return the timing of a scenario's second vehicle."""
        limits = roster(scenario)[1].limits
        delay_ns = scenario.v2v_wait_ns + scenario.system_delay_ns
        return cls(scenario.period_ns, delay_ns, *limits, scenario.fleet.length_m)

    @property
    def period_s(self) -> float:
        """The length of a cycle, s."""
        return self.period_ns * 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """A car and the one ahead, as recorded at the starts of cycles.

    ahead, own (T,) are their speeds, m/s, and gap (T,) is from bumper to bumper, m.
    """

    car: str
    ahead: tuple[float, ...]
    own: Floats
    gap: Floats


def pairs_of(convoy: Convoy, period_s: float) -> list[Pair]:
    """Return the followers of a convoy, each with the car ahead of it."""
    time_s = np.arange(0.0, convoy.time_s[-1] + 1e-6, period_s)

    def at(values: Floats) -> Floats:
        return np.asarray(np.interp(time_s, convoy.time_s, values))

    return [
        Pair(
            car=name,
            ahead=tuple(at(convoy.speed[:, car - 1]).tolist()),
            own=at(convoy.speed[:, car]),
            gap=at(convoy.gap[:, car]),
        )
        for car, name in enumerate(convoy.cars)
        if car
    ]


class Driven(NamedTuple):
    """What a follower did: gap from bumper to bumper (T,), m, and speed (T,), m/s."""

    gap: Floats
    speed: Floats


def driven(law: Law, parameters: Any, setpoint: Setpoint, pair: Pair, timing: Timing) -> Driven:
    """Return how a vehicle under a law follows the recorded predecessor of a pair.

    It begins with the recorded gap and speed. Raises whatever the law raises, and ArithmeticError
    if the law returns no finite number.
    """
    vehicle = _Follower(law, parameters, setpoint, timing)
    period_s = timing.period_s
    gap = float(pair.gap[0]) + timing.length_m
    speed = float(pair.own[0])
    gaps, speeds = [gap], [speed]
    for before, after in zip(pair.ahead[:-1], pair.ahead[1:], strict=True):
        moved, speed = vehicle.step(gap, speed, before)
        gap += 0.5 * (before + after) * period_s - moved
        if gap < timing.length_m:  # a collision: at the bumper, as fast as the one ahead
            gap, speed = timing.length_m, after
        gaps.append(gap)
        speeds.append(speed)
    return Driven(np.array(gaps) - timing.length_m, np.array(speeds))


class _Follower:
    """A vehicle, cycle by cycle, with the commands that are not yet in effect."""

    def __init__(self, law: Law, parameters: Any, setpoint: Setpoint, timing: Timing) -> None:
        self._law, self._parameters, self._setpoint = law, parameters, setpoint
        self._timing = timing
        cycles, first_ns = divmod(timing.delay_ns, timing.period_ns)
        self._period_s = timing.period_s
        self._first_s = first_ns * 1e-9
        self._second_s = (timing.period_ns - first_ns) * 1e-9
        self._coming = [0.0] * (cycles + 1)
        self._state = law.state
        self._before: float | None = None

    def step(self, gap: float, speed: float, ahead: float) -> tuple[float, float]:
        """Return the distance of the next cycle, m, and the speed after it, m/s."""
        self._coming.append(self._command(gap, speed, ahead))
        self._before = speed
        old = self._coming.pop(0)
        first, middle = _moved(speed, old, self._first_s)
        second, after = _moved(middle, self._coming[0], self._second_s)
        return first + second, after

    def _command(self, gap: float, speed: float, ahead: float) -> float:
        timing = self._timing
        before = speed if self._before is None else self._before
        seen = Observation(
            speed,
            self._setpoint,
            Relative(gap, ahead - speed),
            state=self._state,
            period_s=self._period_s,
            uniform=_middle,
            acceleration=(speed - before) / self._period_s,
            length_m=timing.length_m,
        )
        returned = called(self._law, seen, self._parameters)
        if isinstance(returned, Output):
            self._state = returned.state
            returned = returned.acceleration
        if math.isnan(returned):
            raise ArithmeticError(f"{self._law.name} returned {returned}")
        return max(timing.lowest_mps2, min(timing.highest_mps2, float(returned)))


def called(law: Law, seen: Observation, parameters: Any) -> Any:
    """Return what a law returns. Raises ArithmeticError as the law does, LawError for the rest."""
    try:
        return law.acceleration(seen, parameters)
    except ArithmeticError:  # these numbers are outside the law's domain
        raise
    except Exception as error:
        raise raised(f"law {law.name}", law.acceleration, error) from error


def _middle(_: int) -> float:
    return _MIDDLE


def _moved(speed: float, a: float, dt_s: float) -> tuple[float, float]:
    """Return distance (m) and speed (m/s) after dt_s; a vehicle that stops stays there."""
    after = speed + a * dt_s
    if after >= 0.0:
        return (0.5 * (speed + after)) * dt_s, after
    return (0.0 if speed <= 0.0 else -0.5 * speed * speed / a), 0.0
