"""Serves the page of a run: by this process, or by one beside the run."""

from __future__ import annotations

import asyncio
import os
import secrets
import socket
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Final

from zenvoy.analysis.view.controls import NO_CONTROLS, Act, Controls
from zenvoy.analysis.view.listening import address_of, listener
from zenvoy.analysis.view.server import serve
from zenvoy.bus.by_hand import Brake, Lose, ask, pair
from zenvoy.bus.topics import vehicle_name
from zenvoy.cli.beside import Beside, let_requests_end
from zenvoy.cli.terminal import say
from zenvoy.fleet.ending import kill_process
from zenvoy.fleet.folder import LOG
from zenvoy.fleet.requests import requests_to_end
from zenvoy.scenarios import Scenario

_NAME: Final = "view"


def show(log: Path, made: socket.socket, controls: Controls = NO_CONTROLS) -> None:
    """Serve the page of a log on a socket until a request to end; raises LogError."""
    asyncio.run(until_asked_to_end(lambda until: serve(log, made, until, controls)))


async def until_asked_to_end(serve_it: Callable[[asyncio.Event], Awaitable[None]]) -> None:
    """Serve something until an event that a request to end sets."""
    asked_to_end = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in requests_to_end():
        loop.add_signal_handler(number, asked_to_end.set)
    await serve_it(asked_to_end)


class Viewer:
    """Shows a run by a process beside it, from `begin` on and until `close`.

    The run does not depend on that process, which reads the log. In real time the page can also
    interfere: `by_hand` is the end of the world's for its requests. `kills`: the page may kill the
    process of a vehicle. A process that is killed must not take others with it, and must be here.
    """

    def __init__(self, scenario: Scenario, *, kills: bool) -> None:
        self._beside = Beside(_NAME)
        self._size, self._kills = scenario.fleet.size, kills
        self._asks: socket.socket | None = None
        self.by_hand: socket.socket | None = None
        if scenario.clock == "realtime":
            self._asks, self.by_hand = pair()

    def begin(self, folder: Path) -> None:
        """Start to show the run that will be logged in a folder, and print the address."""
        key = secrets.token_urlsafe(12)
        with listener(None) as made:
            main = partial(self._show, folder / LOG, made, key, os.getpid())
            self._beside.start(folder, main)
            # What follows the # stays in the browser. It lets the page interfere with the run.
            say(f"the run is shown at {address_of(made)}{f'#{key}' if self._asks else ''}")

    def stay(self, code: int) -> None:
        """After a run that ended by itself, go on showing it until a request to end."""
        self._beside.stay(code, "the page")

    def close(self) -> None:
        """End the server and its line to the run."""
        self._beside.end()
        for end in (self._asks, self.by_hand):
            if end is not None:
                end.close()

    def _show(self, log: Path, made: socket.socket, key: str, parent: int) -> None:
        """Show the run; this is the main function of the process beside it."""
        let_requests_end()
        asks = self._asks
        if asks is None:
            show(log, made)
            return
        of_vehicle = partial(Act, of="vehicle", allowed=range(1, self._size + 1))
        acts = {
            "brake": of_vehicle(do=lambda vehicle, _: ask(asks, Brake(vehicle))),
            "lose": Act(
                of="percent",
                allowed=range(101),
                do=lambda percent, _: ask(asks, Lose(percent / 100)),
            ),
        }
        if self._kills:
            acts["kill"] = of_vehicle(
                do=lambda vehicle, run: kill_process(vehicle_name(vehicle, self._size), run, parent)
            )
        show(log, made, Controls(key=key, acts=acts))
