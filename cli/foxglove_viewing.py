"""Serves a run to Foxglove and Lichtblick: by this process, or by one beside the run."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from zenvoy.analysis.view.listening import ADDRESS
from zenvoy.cli.beside import Beside, let_requests_end
from zenvoy.cli.terminal import errors, refuse, say
from zenvoy.cli.viewing import until_asked_to_end
from zenvoy.fleet.folder import LOG
from zenvoy.fleet.labels import stage_of
from zenvoy.scenarios import Scenario
from zenvoy.studies.extras import missing

_NAME: Final = "foxglove"
_WHAT: Final = "the server for Foxglove"


def refuse_without_foxglove() -> None:
    """Refuse the option if the package behind it is missing."""
    why = missing("foxglove")
    if why is not None:
        refuse(f"--foxglove: {why}")


def serve_log(log: Path, port: int | None, vehicles: int, ready: Callable[[int], None]) -> None:
    """Serve a log until a request to end; raises LogError and PortError."""
    from zenvoy.analysis.view.live import serve_live

    asyncio.run(until_asked_to_end(partial(serve_live, log, port, stage_of, vehicles, ready)))


def address_at(port: int) -> str:
    """Return the address that a client connects to."""
    return f"ws://{ADDRESS}:{port}"


class FoxgloveServer:
    """Serves a run by a process beside it, from `begin` on and until `close`."""

    def __init__(self, scenario: Scenario) -> None:
        self._beside = Beside(_NAME)
        self._vehicles = scenario.fleet.size

    def begin(self, folder: Path) -> None:
        """Start to serve the run that will be logged in a folder, and print the address."""
        told, tells = os.pipe()
        self._beside.start(folder, partial(self._serve, folder / LOG, tells))
        os.close(tells)
        with os.fdopen(told) as answer:
            port = answer.readline().strip()  # empty if the server ends before it has one
        if port:
            say(f"the run is served to Foxglove at {address_at(int(port))}")
        else:
            errors.print(f"{_WHAT} did not start; see {self._beside.log}")

    def stay(self, code: int) -> None:
        """After a run that ended by itself, go on serving it until a request to end."""
        self._beside.stay(code, _WHAT)

    def close(self) -> None:
        """End the server."""
        self._beside.end()

    def _serve(self, log: Path, tells: int) -> None:
        """Serve the run; this is the main function of the process beside it."""
        let_requests_end()

        def tell(port: int) -> None:
            with os.fdopen(tells, "w") as answer:
                answer.write(f"{port}\n")

        serve_log(log, None, self._vehicles, tell)
