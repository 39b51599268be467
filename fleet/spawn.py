"""Forks a named child that dies with its parent and writes to a log of its own.

Forking from a process that has imported everything and opened no Zenoh session starts 40 vehicles
in a fraction of a second; filterpy alone takes more than a second to import.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

from setproctitle import setproctitle

from zenvoy.bus.errors import StalledError, StoppedError
from zenvoy.fleet.ends import (
    BROKEN,
    DONE,
    EXHAUSTED,
    STALLED,
    STOPPED,
    Tell,
    last_words,
    want_of,
)
from zenvoy.fleet.priority import prefer_throughput
from zenvoy.laws.errors import LawError

_PR_SET_PDEATHSIG: Final = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A row of the process table: a name, what it runs, and how it ends when its parent dies.

    `run` stands beside the name in `ps`; `prefer` is called first, to choose how it is scheduled.
    Where it is not `essential`, the run goes on without it.
    """

    name: str
    run: str
    main: Callable[[], None]
    on_orphaned: signal.Signals = signal.SIGKILL
    prefer: Callable[[], None] = prefer_throughput
    essential: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Child:
    """A running program."""

    program: Program
    pid: int
    pidfd: int
    log: Path

    def signal(self, number: signal.Signals) -> None:
        """Send a signal; nothing happens where the child has ended."""
        signal.pidfd_send_signal(self.pidfd, number)


def spawn(program: Program, log: Path, tell: Tell) -> Child:
    """Start a program in a child process; its output and errors go to `log`, last words to `tell`.

    To be called with requests to end held. The child holds SIGTERM until its program lets it come:
    a request that comes before is heard then.
    """
    parent = os.getpid()
    _flush()
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
    pid = os.fork()
    if pid == 0:
        _be_child(program, file, parent, tell)
    os.close(file)  # its number is free for the next one, whatever the limit
    return Child(program=program, pid=pid, pidfd=os.pidfd_open(pid), log=log)


def _be_child(program: Program, log: int, parent: int, tell: Tell) -> NoReturn:
    """Run the program and leave without a return into the parent's frames."""
    try:
        _settle(program, log, parent)
        program.main()
        _leave(DONE)
    except BaseException as error:  # noqa: BLE001  # else the child would go on in its parent's code
        # The error holds the session. Where that is dropped it is closed, which may wait for a peer
        # that is frozen: so leave before.
        try:
            _leave(_status(program, error, tell))
        finally:
            os._exit(1)


def _settle(program: Program, log: int, parent: int) -> None:
    """Become a process of its own: its signals, its streams, its name."""
    for number in (signal.SIGINT, signal.SIGHUP):  # the terminal's; the supervisor's business
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGHUP))
    die_with(parent, program.on_orphaned)
    os.dup2(log, 1)
    os.dup2(log, 2)
    # Whatever they were in the parent; and a log is in UTF-8 whatever the locale.
    sys.stdout = sys.stderr = open(  # noqa: SIM115  # closed by the end of the process alone
        2, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False
    )
    setproctitle(f"zenvoy {program.name} {program.run}")
    program.prefer()


def _status(program: Program, error: BaseException, tell: Tell) -> int:
    """Exit status after an error; what there is to say of it is told, or written to the log."""
    if isinstance(error, StoppedError):
        return STOPPED
    if isinstance(error, StalledError):
        tell(last_words(program.name, str(error), error.culprits))
        return STALLED
    if isinstance(error, LawError):
        tell(last_words(program.name, str(error)))
        return BROKEN
    want = want_of(error)
    if want is not None:
        tell(last_words(program.name, want))
        return EXHAUSTED
    with suppress(OSError):
        traceback.print_exception(error)
    return 1


def _leave(code: int) -> NoReturn:
    _flush()
    os._exit(code)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # its disk may be full, or it may be closed
            if stream is not None:  # as in a daemon
                stream.flush()


def die_with(parent: int, number: signal.Signals) -> None:
    """Have the kernel send `number` when the parent dies, even by kill -9."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)
    if os.getppid() != parent:  # it died before the request
        os.kill(os.getpid(), number)
