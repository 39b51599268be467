"""Becomes a command that dies with its parent: `python as_child.py SETTINGS COMMAND …`.

A process must set this up itself, and a fork of the tests cannot do it: pytest's workers have
threads, and a fork of a process with threads may hold a lock for ever.
"""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import sys
from typing import Any, Final

_PR_SET_PDEATHSIG: Final = 1


def as_child(
    *command: str, limit: tuple[int, int] | None = None, ignores_interrupts: bool = False
) -> list[str]:
    """Return the command line of a command that the kernel kills when this process ends.

    Ctrl-C ends it, even if a shell runs the tests in the background, unless it ignores interrupts.
    `limit` is a resource and its limit, as in a shell's `ulimit`.
    """
    settings = json.dumps([os.getpid(), limit, ignores_interrupts])
    return [sys.executable, "-I", "-S", __file__, settings, *command]


def main(settings: str, command: list[str]) -> None:
    """Set up this process, and run the command in its place."""
    values: list[Any] = json.loads(settings)
    parent, limit, ignores_interrupts = values
    signal.signal(signal.SIGINT, signal.SIG_IGN if ignores_interrupts else signal.SIG_DFL)
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it has ended before the call above
        os.kill(os.getpid(), signal.SIGKILL)
    if limit is not None:
        resource.setrlimit(limit[0], (limit[1], limit[1]))
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
