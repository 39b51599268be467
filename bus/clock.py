"""The only module that reads a clock. Simulation time is an argument everywhere else."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

WallClock = Callable[[], int]


def wall_ns() -> int:
    """Return monotonic wall time, ns. Its origin is arbitrary, so only differences matter."""
    return time.monotonic_ns()


def pause(for_s: float = 0.0002) -> None:
    """Give up the processor, by default for about as long as a message takes.

    Zenoh can block on one queue only. A caller that watches several looks at each in turn, and
    without a pause it would take a core from the processes for which it waits. A longer or a
    shorter pause only changes how soon a message is seen.
    """
    time.sleep(for_s)  # no call of Zenoh waits for several queues, so the caller looks at each


@dataclass(frozen=True, slots=True)
class WallTime:
    """Simulation time on the wall clock: time 0 is at `start_ns`, and time runs at `speed`.

    On Linux all processes of a machine have the same `wall_ns`, so they can share a start.
    """

    start_ns: int
    speed: float = 1.0

    def wall_ns(self, time_ns: int) -> int:
        """Return the wall time of an instant of simulation time."""
        return self.start_ns + round(time_ns / self.speed)

    def time_ns(self, wall_ns: int) -> int:
        """Return the simulation time at an instant of wall time; 0 before the start."""
        return max(0, round((wall_ns - self.start_ns) * self.speed))


def age_s(modified_ns: int) -> float:
    """Return how long ago a file was modified, s, by the time of modification that it has."""
    return (time.time_ns() - modified_ns) * 1e-9


def stamp() -> str:
    """Return the local date and time to the second, for names of folders."""
    return datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
