"""Checks of the system's limits, made before anything starts.

Beyond these limits Zenoh's threads and some libraries hang or die in silence. The processes that
wait for them would then be blamed.
"""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path
from typing import Final

# What a process needs, measured with 3 to 40 vehicles: 12 to 30 threads, and 16 descriptors plus
# one for each process of the run.
_THREADS: Final = 20
_DESCRIPTORS: Final = 24
_MIB: Final = 1_048_576  # bytes
_LEAST_MEMORY: Final = 384 * _MIB  # with 200 MiB the import of scipy never ends
# A process of a fleet takes 1.5 GB of addresses with its 26 threads, each with an arena of its own.
# With less, Zenoh's threads may die in silence.
_LEAST_MEMORY_WITH_ZENOH: Final = 2048 * _MIB

_ZENOH_THREAD: Final = b"app-0"  # the first session starts it, and it never ends


class LimitError(OSError):
    """A limit of the system leaves no room for the run; the text names it in a line."""


def require_no_session() -> None:
    """Raise LimitError if this process has ever opened a Zenoh session.

    A fork does not copy Zenoh's threads, and a session of the child would wait for them in vain.
    """
    if _ZENOH_THREAD in _names_of_threads():
        raise LimitError(
            "this process has opened a Zenoh session and can no longer fork a fleet; "
            "run the fleet from another process, or in this one without Zenoh"
        )


def _names_of_threads() -> set[bytes]:
    names = set()
    for name in Path("/proc/self/task").glob("*/comm"):
        with suppress(OSError):  # it has just ended
            names.add(name.read_bytes().strip())
    return names


def require_memory() -> None:
    """Raise LimitError if there is too little memory for the libraries (`ulimit -v`)."""
    _require_memory(_LEAST_MEMORY, "are needed")


def _require_memory(least: int, what: str) -> None:
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < least:
        raise LimitError(
            f"memory is limited to {limit // 1024} KiB (ulimit -v); "
            f"at least {least // 1024} KiB {what}"
        )


def require_room_for(processes: int) -> None:
    """Raise LimitError if memory, threads or file descriptors are too few for so many processes.

    Raises the soft limit of file descriptors as far as the hard one allows.
    """
    _require_memory(
        _LEAST_MEMORY_WITH_ZENOH, "are needed for processes on Zenoh, less for the engine arrays"
    )
    needed = processes + _DESCRIPTORS
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < needed:
        raise LimitError(
            f"file descriptors are limited to {hard} (ulimit -n); "
            f"{processes} processes need {needed} each"
        )
    if soft != resource.RLIM_INFINITY and soft < needed:
        resource.setrlimit(resource.RLIMIT_NOFILE, (needed, hard))
    _require_threads(processes)


def _require_threads(processes: int) -> None:
    limit, _ = resource.getrlimit(resource.RLIMIT_NPROC)
    if limit == resource.RLIM_INFINITY or os.geteuid() == 0:  # the limit does not bind root
        return
    needed, present = processes * _THREADS, _own_threads()
    if present + needed > limit:
        raise LimitError(
            f"processes and threads are limited to {limit} (ulimit -u), and {present} exist "
            f"already; {processes} processes need about {needed}"
        )


def _own_threads() -> int:
    """Count the threads of all processes of this user."""
    count = 0
    for task in Path("/proc").glob("[0-9]*/task"):
        try:
            if task.stat().st_uid == os.geteuid():
                count += len(os.listdir(task))
        except OSError:  # it has just ended
            continue
    return count
