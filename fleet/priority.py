"""How a process wants to be scheduled: long time slices in lock-step, short ones in real time."""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from typing import Final

_PR_SET_TIMERSLACK: Final = 29
_SCHED_SETATTR: Final = {"x86_64": 314, "aarch64": 274}
_SLICE_NS: Final = 100_000  # the shortest that Linux grants


def prefer_throughput() -> None:
    """Ask for long time slices, and so fewer switches per cycle (SCHED_BATCH, unprivileged)."""
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def prefer_latency() -> None:
    """Ask to be woken at once, and for short time slices; this needs no privileges.

    Timers fire on time instead of up to 50 µs late, the scheduler prefers short slices (Linux 6.12
    and later, nothing happens before), and Python threads switch after at most 0.5 ms.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    number = _SCHED_SETATTR.get(platform.machine())
    if number is not None:  # struct sched_attr: size, policy, flags, nice, priority, runtime, …
        nice = os.getpriority(os.PRIO_PROCESS, 0)
        attributes = struct.pack("=IIQiIQQQ", 48, os.SCHED_OTHER, 0, nice, 0, _SLICE_NS, 0, 0)
        libc.syscall(number, 0, attributes, 0)
    sys.setswitchinterval(0.0005)
