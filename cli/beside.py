"""Shows a run from a process beside it, on which the run does not depend."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final

from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, say
from zenvoy.fleet.folder import LOGS
from zenvoy.fleet.requests import requests_held
from zenvoy.fleet.spawn import Child, Program, spawn

_YIELDS: Final = 10  # nice: where processors are scarce, the run comes first


class Beside:
    """A server or a table, which starts with the run. `end` ends it, which every user must call."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._child: Child | None = None

    def start(self, folder: Path, main: Callable[[], None]) -> None:
        """Start it, given as its main function, for the run in a folder."""
        program = Program(name=self._name, run=folder.name, main=main, prefer=_yield_to_the_run)
        with requests_held():
            self._child = spawn(program, folder / LOGS / f"{self._name}.log", lambda _: None)

    @property
    def log(self) -> Path | None:
        """Where it writes its own output; None if it has not started."""
        return None if self._child is None else self._child.log

    def stay(self, code: int, what: str) -> None:
        """After a run that ended by itself, go on until a request to end; what: the server."""
        if self._child is None or code == exits.INTERRUPTED:
            return
        say(f"{what} stays until Ctrl-C")
        with suppress(KeyboardInterrupt):
            os.waitid(os.P_PIDFD, self._child.pidfd, os.WEXITED | os.WNOWAIT)
            errors.print(f"{what} has ended; see {self._child.log}")

    def end(self) -> None:
        """End it, if it has started; it has nothing to finish."""
        if self._child is not None:
            self._child.signal(signal.SIGKILL)
            os.waitpid(self._child.pid, 0)
            os.close(self._child.pidfd)
            self._child = None


def let_requests_end() -> None:
    """In the process of the server: let SIGTERM, which `spawn` holds back, end it."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))


def _yield_to_the_run() -> None:
    os.nice(_YIELDS)
