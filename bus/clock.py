"""The only module that reads a clock. Simulation time is an argument everywhere else."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import datetime

WallClock = Callable[[], int]


def wall_ns() -> int:
    """Monotonic wall time, ns; its zero means nothing."""
    return time.monotonic_ns()


def stamp() -> str:
    """Local date and time for names of folders, to the second."""
    return datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
