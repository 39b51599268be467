"""What the system allows a run, looked at before anything starts.

Past these limits Zenoh's threads and some libraries hang or die without a word, so that others
wait in vain and would be blamed for it.
"""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path
from typing import Final

# Of each process, measured with 3 to 40 vehicles: 12 to 30 threads, and 16 descriptors beside one
# for each process of the run.
_THREADS: Final = 20
_DESCRIPTORS: Final = 24
_LEAST_MEMORY: Final = 384 * 1_048_576  # bytes; with 200 MiB scipy's import never ends

_ZENOH_THREAD: Final = b"app-0"  # every session starts it, and none ends it


class LimitError(OSError):
    """A limit of the system leaves no room for the run; the text names it in a line."""


def require_no_session() -> None:
    """Raise LimitError where this process has opened a Zenoh session, now closed or not.

    Zenoh's threads do not come along in a fork, and a session of the child waits for them in vain.
    """
    if _ZENOH_THREAD in _names_of_threads():
        raise LimitError(
            "this process has opened a Zenoh session, after which no fleet can be forked from it; "
            "run the fleet from another process, or in this one without Zenoh"
        )


def _names_of_threads() -> set[bytes]:
    names = set()
    for name in Path("/proc/self/task").glob("*/comm"):
        with suppress(OSError):  # it has just ended
            names.add(name.read_bytes().strip())
    return names


def require_memory() -> None:
    """Raise LimitError where even the libraries would not go into memory (`ulimit -v`)."""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < _LEAST_MEMORY:
        raise LimitError(
            f"memory is limited to {limit // 1024} KiB (ulimit -v); "
            f"at least {_LEAST_MEMORY // 1024} KiB are needed"
        )


def require_room_for(processes: int) -> None:
    """Raise LimitError where so many processes get too few threads or file descriptors.

    The soft limit of file descriptors is raised as far as the hard one allows.
    """
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
    if limit == resource.RLIM_INFINITY or os.geteuid() == 0:  # root is not held to it
        return
    needed, present = processes * _THREADS, _own_threads()
    if present + needed > limit:
        raise LimitError(
            f"processes and threads are limited to {limit} (ulimit -u) with {present} there "
            f"already; {processes} processes need some {needed}"
        )


def _own_threads() -> int:
    """Threads of this user, over all processes."""
    count = 0
    for task in Path("/proc").glob("[0-9]*/task"):
        try:
            if task.stat().st_uid == os.geteuid():
                count += len(os.listdir(task))
        except OSError:  # it has just ended
            continue
    return count
