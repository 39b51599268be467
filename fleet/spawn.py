"""Forks a named child process that dies with its parent and writes to a log of its own.

The parent has imported everything and opened no Zenoh session, so forks start 40 vehicles in a
fraction of a second. Importing filterpy alone takes more than a second.
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

from zenvoy.bus.errors import StalledError, StoppedError, VehicleLostError
from zenvoy.fleet.ends import (
    DONE,
    EXHAUSTED,
    LAW_FAILED,
    STALLED,
    STOPPED,
    VEHICLE_LOST,
    Send,
    last_words,
    shortage_of,
)
from zenvoy.fleet.priority import prefer_throughput
from zenvoy.laws.errors import LawError

_PR_SET_PDEATHSIG: Final = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A row of the process table: a name, a main function, and a signal for an orphan.

    `run` stands beside the name in `ps`. The process first calls `prefer` to set its scheduling. If
    it is not `essential`, the run goes on without it. A program with `killed_with` kills itself
    when it has done its work, and these are its last words; then its successor starts, if any.
    """

    name: str
    run: str
    main: Callable[[], None]
    on_orphaned: signal.Signals = signal.SIGKILL
    prefer: Callable[[], None] = prefer_throughput
    essential: bool = True
    killed_with: str = ""
    successor: Program | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Child:
    """A running program."""

    program: Program
    pid: int
    pidfd: int
    log: Path

    def signal(self, number: signal.Signals) -> None:
        """Send a signal; nothing happens if the child has ended."""
        signal.pidfd_send_signal(self.pidfd, number)


def spawn(program: Program, log: Path, send: Send) -> Child:
    """Start a program in a child process; its output goes to `log`, its last words to `send`.

    Call it inside `requests_held`. The child keeps SIGTERM blocked until its program unblocks it;
    an earlier request is delivered then.
    """
    parent = os.getpid()
    _flush()
    file = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o644)
    pid = os.fork()
    if pid == 0:
        _be_child(program, file, parent, send)
    os.close(file)  # a fleet needs many descriptors
    return Child(program=program, pid=pid, pidfd=os.pidfd_open(pid), log=log)


def _be_child(program: Program, log: int, parent: int, send: Send) -> NoReturn:
    """Run the program and exit; never return into the frames of the parent."""
    try:
        _settle(program, log, parent)
        program.main()
        if program.killed_with:
            send(last_words(program.name, program.killed_with))
            _flush()
            os.kill(os.getpid(), signal.SIGKILL)
        _leave(DONE)
    finally:
        # Only an error comes here. Nothing may leave this function, not even SystemExit: after a
        # fork, the frames below belong to the parent, and its handlers would run a second time.
        # The error keeps the session alive. Exit before it is dropped: that would close the
        # session, which may wait for a frozen peer.
        try:
            error = sys.exception()
            assert error is not None
            _leave(_status(program, error, send))
        finally:
            os._exit(1)


def _settle(program: Program, log: int, parent: int) -> None:
    """Set up the signals, streams and name of this process."""
    for number in (signal.SIGINT, signal.SIGHUP):  # from the terminal; the supervisor handles them
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGHUP))
    die_with(parent, program.on_orphaned)
    os.dup2(log, 1)
    os.dup2(log, 2)
    # Replace the streams of the parent. A log is in UTF-8, whatever the locale.
    sys.stdout = sys.stderr = os.fdopen(
        2, "w", buffering=1, encoding="utf-8", errors="backslashreplace", closefd=False
    )
    setproctitle(f"zenvoy {program.name} {program.run}")
    program.prefer()


def _status(program: Program, error: BaseException, send: Send) -> int:
    """Return the exit status for an error; report it by last words or in the log."""
    if isinstance(error, StoppedError):
        return STOPPED
    if isinstance(error, StalledError):
        send(last_words(program.name, str(error), error.culprits))
        return STALLED
    if isinstance(error, VehicleLostError):
        send(last_words(program.name, str(error), (error.name,)))
        return VEHICLE_LOST
    if isinstance(error, LawError):
        send(last_words(program.name, str(error)))
        return LAW_FAILED
    shortage = shortage_of(error)
    if shortage is not None:
        send(last_words(program.name, shortage))
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
            if stream is not None:  # it is None in a daemon
                stream.flush()


def die_with(parent: int, number: signal.Signals) -> None:
    """Have the kernel send `number` when the parent dies, even by kill -9."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)
    if os.getppid() != parent:  # it died before the call above
        os.kill(os.getpid(), number)
