"""The only module that reads a clock. Simulation time is an argument everywhere else."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

WallClock = Callable[[], int]


def wall_ns() -> int:
    """Return monotonic wall time, ns. Its origin is arbitrary: only differences have a meaning."""
    return time.monotonic_ns()


def pause() -> None:
    """Give up the processor for about as long as a message takes.

    Zenoh can block on one queue only; a caller that watches several polls them with this between.
    """
    time.sleep(0.0002)  # nothing is taken to have come by then: the caller polls again


@dataclass(frozen=True, slots=True)
class WallTime:
    """Simulation time on the wall clock: time 0 is at `start_ns`, and runs `speed` times as fast.

    On Linux `wall_ns` is the same clock for all processes of a machine, so they share a start.
    """

    start_ns: int
    speed: float = 1.0

    def wall_ns(self, time_ns: int) -> int:
        """Wall time of an instant of simulation time."""
        return self.start_ns + round(time_ns / self.speed)

    def time_ns(self, wall_ns: int) -> int:
        """Simulation time at an instant of wall time; 0 before the start."""
        return max(0, round((wall_ns - self.start_ns) * self.speed))


def stamp() -> str:
    """Local date and time for names of folders, to the second."""
    return datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
