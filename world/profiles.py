"""Speed profiles that a scenario gives to a vehicle: points with straight lines between them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Sine, Trace

_NS = 1e-9

Floats = NDArray[np.float64]


class Profile(Protocol):
    """A speed over time, from `start_ns` (included) to `end_ns` (excluded)."""

    @property
    def start_ns(self) -> int: ...

    @property
    def end_ns(self) -> int: ...

    def next_point(self, time_ns: int) -> tuple[int, float]:
        """Return time (ns) and speed (m/s) of the first point after `time_ns`.

        `time_ns` must be within the profile.
        """
        ...


class SineProfile:
    """A sine, or a linear chirp, with a point at the start of every cycle."""

    def __init__(self, sine: Sine, period_ns: int) -> None:
        self.start_ns, self.end_ns = sine.start_ns, sine.end_ns
        self._mean, self._amplitude = sine.mean_mps, sine.amplitude_mps
        end_hz = sine.frequency_hz if sine.to_frequency_hz is None else sine.to_frequency_hz
        self._from_hz = sine.frequency_hz
        self._rise_hz_per_s = (end_hz - sine.frequency_hz) / sine.duration_s
        self._period_ns = period_ns

    def next_point(self, time_ns: int) -> tuple[int, float]:
        """Return the next start of a cycle, or the end, and the speed there.

        The speed is mean + amplitude · sin 2π(f t + r t²/2): t is the time since the start, and r
        the rate at which the frequency f rises.
        """
        at_ns = min((time_ns // self._period_ns + 1) * self._period_ns, self.end_ns)
        t = (at_ns - self.start_ns) * _NS
        turns = self._from_hz * t + 0.5 * self._rise_hz_per_s * t * t
        return at_ns, self._mean + self._amplitude * math.sin(2.0 * math.pi * turns)


class TraceProfile:
    """The points of a trace."""

    def __init__(self, trace: Trace) -> None:
        self._times_ns = trace.times_ns
        self._speeds = [speed for _, speed in trace.points]
        self.start_ns, self.end_ns = self._times_ns[0], self._times_ns[-1]

    def next_point(self, time_ns: int) -> tuple[int, float]:
        """Return the first point of the trace after `time_ns`."""
        index = bisect_right(self._times_ns, time_ns)
        return self._times_ns[index], self._speeds[index]


@dataclass(frozen=True, slots=True)
class Following:
    """A vehicle whose speed follows a profile.

    It accelerates from its actual speed towards the next point. So the next point corrects a
    deviation from rounding, a brake or a collision, and the second point one at the start.
    """

    vehicle: int
    profile: Profile

    def changes(self, after_ns: int, before_ns: int) -> Iterator[int]:
        """Yield the instants between the two times at which the acceleration changes."""
        start_ns, end_ns = self.profile.start_ns, self.profile.end_ns
        time_ns = after_ns
        if time_ns < start_ns < before_ns:
            yield start_ns
        time_ns = max(time_ns, start_ns)
        while time_ns < min(before_ns, end_ns):
            time_ns, _ = self.profile.next_point(time_ns)
            if time_ns < before_ns:
                yield time_ns

    def in_force(self, time_ns: int) -> bool:
        """Return whether `time_ns` is within the profile."""
        return self.profile.start_ns <= time_ns < self.profile.end_ns

    def acceleration(self, time_ns: int, speed: Floats) -> Floats | None:
        """Return the acceleration from `time_ns` on (m/s²), or None outside the profile.

        speed: at `time_ns`, m/s.
        """
        if not self.in_force(time_ns):
            return None
        at_ns, target = self.profile.next_point(time_ns)
        return np.asarray((target - speed) / ((at_ns - time_ns) * _NS))
