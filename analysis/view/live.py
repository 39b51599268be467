"""Serves a run to Foxglove and Lichtblick over their WebSocket protocol, on this machine.

The server reads the log that the run writes, so no client can hold up a run: what a slow one does
not take in time is dropped.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Final

import foxglove
from foxglove.websocket import Capability, WebSocketServer

from zenvoy.analysis.view.feed import Clients, Feed, StageOf
from zenvoy.analysis.view.listening import ADDRESS, PortError

PORT: Final = 8765
"""The port where Foxglove looks first."""

_BACKLOG_BYTES: Final = 64 << 20  # per client, about
_MOST: Final = 1024  # messages in a backlog
_FEWEST: Final = 64


async def serve_live(
    path: Path,
    port: int | None,
    stage_of: StageOf,
    vehicles: int,
    ready: Callable[[int], None],
    until: asyncio.Event,
) -> None:
    """Serve the run logged at `path`, of so many vehicles, until an event is set.

    The log may not exist yet. `ready` gets the port: for None the usual one, or a free one if that
    is taken. Raises PortError, and LogError for a file that is not the log of a run.
    """
    clients = Clients(asyncio.get_running_loop())
    context = foxglove.Context()
    server = _start(port, context, clients, _backlog(vehicles))
    ready(server.port)
    feed = Feed(path, stage_of, context, server, clients)
    feeding = asyncio.create_task(feed.run())
    ending = asyncio.create_task(until.wait())
    try:
        await asyncio.wait({feeding, ending}, return_when=asyncio.FIRST_COMPLETED)
        if feeding.done():
            await feeding  # so that an error of it ends the server
    finally:
        feeding.cancel()
        ending.cancel()
        server.stop()


def _start(
    port: int | None, context: foxglove.Context, clients: Clients, backlog: int
) -> WebSocketServer:
    for wanted in (PORT, 0) if port is None else (port,):
        try:
            return foxglove.start_server(
                name="Zenvoy",
                host=ADDRESS,
                port=wanted,
                capabilities=[Capability.Time, Capability.Parameters],
                server_listener=clients,
                context=context,
                message_backlog_size=backlog,
            )
        except RuntimeError as error:  # the SDK has no other class for it
            why = str(error)
    raise PortError(f"port {wanted}: {why.rpartition(': ')[2].partition(' (')[0]}")


def _backlog(vehicles: int) -> int:
    """Return how many messages may wait for a client; a cycle's frames are the largest of ten."""
    per_message = 6 * vehicles * min(vehicles, 80)
    return min(max(_BACKLOG_BYTES // max(1, per_message), _FEWEST), _MOST)
