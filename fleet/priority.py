"""What a process asks of the scheduler: long turns in lock-step, short ones in real time."""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from typing import Final

_PR_SET_TIMERSLACK: Final = 29
_SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}
_SLICE_NS: Final = 100_000  # the shortest that Linux gives


def prefer_throughput() -> None:
    """Ask the scheduler for long turns (SCHED_BATCH, unprivileged): fewer switches per cycle."""
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def prefer_latency() -> None:
    """Ask to be woken at once, for short turns; unprivileged, and nothing where it is not offered.

    Timers fire on time instead of up to 50 µs later, the scheduler (Linux 6.12 and later) takes
    short turns first, and a thread of Python waits for another one 0.5 ms at the most.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    number = _SCHED_SETATTR.get(platform.machine())
    if number is not None:  # struct sched_attr: size, policy, flags, nice, priority, runtime, …
        nice = os.getpriority(os.PRIO_PROCESS, 0)
        attributes = struct.pack("=IIQiIQQQ", 48, os.SCHED_OTHER, 0, nice, 0, _SLICE_NS, 0, 0)
        libc.syscall(number, 0, attributes, 0)
    sys.setswitchinterval(0.0005)
