"""Serves the page of a run: by this process, or by one beside the run."""

from __future__ import annotations

import asyncio
import os
import secrets
import signal
import socket
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from zenvoy.analysis.view.controls import NO_CONTROLS, Controls
from zenvoy.analysis.view.server import address_of, listener, serve
from zenvoy.bus.by_hand import ask_to_brake, pair
from zenvoy.bus.topics import vehicle_name
from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, say
from zenvoy.fleet.ending import kill_process
from zenvoy.fleet.folder import LOG, LOGS
from zenvoy.fleet.requests import requests_held, requests_to_end
from zenvoy.fleet.spawn import Child, Program, spawn
from zenvoy.scenarios import Scenario

_NAME: Final = "view"
_YIELDS: Final = 10  # nice: where processors are scarce, the run comes first


def show(log: Path, made: socket.socket, controls: Controls = NO_CONTROLS) -> None:
    """Serve the page of a log on a socket until a request to end; raises LogError."""
    asyncio.run(_show(log, made, controls))


async def _show(log: Path, made: socket.socket, controls: Controls) -> None:
    asked_to_end = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in requests_to_end():
        loop.add_signal_handler(number, asked_to_end.set)
    await serve(log, made, asked_to_end, controls)


class Viewer:
    """Shows a run by a process beside it, from `begin` on and until the context ends.

    The run does not depend on that process, which reads the log. In real time the page can also
    interfere: `by_hand` is the end of the world's for its requests.
    """

    def __init__(self, scenario: Scenario, per_process: int) -> None:
        self._child: Child | None = None
        self._size, self._per_process = scenario.fleet.size, per_process
        self._asks: socket.socket | None = None
        self.by_hand: socket.socket | None = None
        if scenario.clock == "realtime":
            self._asks, self.by_hand = pair()

    def __enter__(self) -> Self:
        return self

    def begin(self, folder: Path) -> None:
        """Start to show the run that will be logged in a folder, and print the address."""
        key = secrets.token_urlsafe(12)
        with listener(None) as made:
            program = Program(
                name=_NAME,
                run=folder.name,
                main=partial(self._show, folder / LOG, made, key, os.getpid()),
                prefer=_yield_to_the_run,
            )
            with requests_held():
                self._child = spawn(program, folder / LOGS / f"{_NAME}.log", lambda _: None)
            # What follows the # stays in the browser. It lets the page interfere with the run.
            say(f"the run is shown at {address_of(made)}{f'#{key}' if self._asks else ''}")

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
        for end in (self._asks, self.by_hand):
            if end is not None:
                end.close()

    def _show(self, log: Path, made: socket.socket, key: str, parent: int) -> None:
        """Show the run; this is the main function of the process beside it."""
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
        asks = self._asks
        if asks is None:
            show(log, made)
            return
        acts = {"brake": lambda vehicle, _: ask_to_brake(asks, vehicle)}
        if self._per_process == 1:  # a process that is killed must not take others with it
            acts["kill"] = lambda vehicle, run: kill_process(
                vehicle_name(vehicle, self._size), run, parent
            )
        show(log, made, Controls(key=key, acts=acts))


def _yield_to_the_run() -> None:
    os.nice(_YIELDS)
