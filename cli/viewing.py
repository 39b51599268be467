"""Serves the page of a run until a signal asks to end."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path

from zenvoy.analysis.view.server import serve
from zenvoy.fleet.requests import requests_to_end


def show(log: Path, made: socket.socket) -> None:
    """Serve the page of a log on a socket until a request to end; raises LogError."""
    asyncio.run(_show(log, made))


async def _show(log: Path, made: socket.socket) -> None:
    asked_to_end = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in requests_to_end():
        loop.add_signal_handler(number, asked_to_end.set)
    await serve(log, made, asked_to_end)
