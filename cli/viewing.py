"""Serves the page of a run: by this process, or by one beside the run."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from zenvoy.analysis.view.server import address_of, listener, serve
from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, say
from zenvoy.fleet.folder import LOG, LOGS
from zenvoy.fleet.requests import requests_held, requests_to_end
from zenvoy.fleet.spawn import Child, Program, spawn

_NAME: Final = "view"
_YIELDS: Final = 10  # nice: where processors are scarce, the run comes first


def show(log: Path, made: socket.socket) -> None:
    """Serve the page of a log on a socket until a request to end; raises LogError."""
    asyncio.run(_show(log, made))


async def _show(log: Path, made: socket.socket) -> None:
    asked_to_end = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in requests_to_end():
        loop.add_signal_handler(number, asked_to_end.set)
    await serve(log, made, asked_to_end)


class Viewer:
    """Shows a run by a process beside it, from `begin` on and until the context ends.

    The run does not depend on that process, which only reads the log.
    """

    def __init__(self) -> None:
        self._child: Child | None = None

    def __enter__(self) -> Self:
        return self

    def begin(self, folder: Path) -> None:
        """Start to show the run that will be logged in a folder, and print the address."""
        with listener(None) as made:
            program = Program(
                name=_NAME,
                run=folder.name,
                main=partial(_show_beside, folder / LOG, made),
                prefer=_yield_to_the_run,
            )
            with requests_held():
                self._child = spawn(program, folder / LOGS / f"{_NAME}.log", lambda _: None)
            say(f"the run is shown at {address_of(made)}")

    def stay(self, code: int) -> None:
        """After a run that ended by itself, go on showing it until a request to end."""
        if self._child is None or code == exits.INTERRUPTED:
            return
        say("the page stays until Ctrl-C")
        with suppress(KeyboardInterrupt):
            os.waitid(os.P_PIDFD, self._child.pidfd, os.WEXITED | os.WNOWAIT)
            errors.print(f"the page has ended; see {self._child.log}")

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._child is not None:
            self._child.signal(signal.SIGKILL)  # it has nothing to finish
            os.waitpid(self._child.pid, 0)
            os.close(self._child.pidfd)
            self._child = None


def _show_beside(log: Path, made: socket.socket) -> None:
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
    show(log, made)


def _yield_to_the_run() -> None:
    os.nice(_YIELDS)
