"""Sends the messages of a log to the clients of Foxglove's protocol that watch it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

import foxglove
from foxglove.websocket import (
    ChannelView,
    Client,
    Parameter,
    ServerListener,
    WebSocketServer,
)
from google.protobuf.message import DecodeError
from pydantic import ValidationError

from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.growing_log import GrowingLog, Place, still_limit_s
from zenvoy.bus.clock import wall_ns
from zenvoy.bus.log_format import EPOCH_NS
from zenvoy.bus.scene import SCENE_TOPICS, Scene, Stage
from zenvoy.bus.schemas import schema_of
from zenvoy.bus.topics import LOGGED, REALTIME, TRUTH
from zenvoy.scenarios import Scenario

StageOf = Callable[[Scenario], Stage]

_PAUSE_S: Final = 0.1  # between looks at a log that has not grown
_SETTLE_S: Final = 0.5  # in which a client subscribes to its topics, one after the other
_TURN_NS: Final = 20_000_000  # of a replay
_MESSAGES: Final = {
    **{topic.log_name: topic.message.DESCRIPTOR.full_name for topic in (*LOGGED, REALTIME)},
    **SCENE_TOPICS,
}
"""Messages by topic, of all topics that are served."""


class Clients(ServerListener):
    """Knows which clients watch. The server calls it in threads of its own."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._watching: set[tuple[int, int]] = set()  # clients and channels
        self._known: set[int] = set()
        self.newcomer = asyncio.Event()
        """Whether a client has begun to watch since `meet`."""
        self.greet: Callable[[], None] = lambda: None
        """What to do when a client asks for parameters."""

    def on_get_parameters(
        self, client: Client, param_names: list[str], request_id: str | None = None
    ) -> list[Parameter]:
        """Greet a client. Studio and Lichtblick ask this first, and now and then again."""
        self._loop.call_soon_threadsafe(self.greet)
        return []

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Note a client that watches a topic."""
        self._loop.call_soon_threadsafe(self._come, client.id, channel.id)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """Forget a client that does not watch a topic any more."""
        self._loop.call_soon_threadsafe(self._watching.discard, (client.id, channel.id))

    def __bool__(self) -> bool:
        return bool(self._watching)

    def meet(self) -> None:
        """Note that those who watch now see what follows."""
        self._known |= {client for client, _ in self._watching}
        self.newcomer.clear()

    def _come(self, client: int, channel: int) -> None:
        self._watching.add((client, channel))
        if client not in self._known:
            self.newcomer.set()


class Feed:
    """Sends the messages of a log, and a scene if the log has none."""

    def __init__(
        self,
        path: Path,
        stage_of: StageOf,
        context: foxglove.Context,
        server: WebSocketServer,
        clients: Clients,
    ) -> None:
        self._log = GrowingLog(path)
        self._stage_of = stage_of
        self._server = server
        self._clients = clients
        self._begun = False
        self._told_ns = EPOCH_NS
        self._scene: Scene | None = None
        self._scenario: Scenario | None = None
        self._channels = {
            topic: foxglove.Channel(
                topic,
                schema=foxglove.Schema(name=name, encoding="protobuf", data=schema_of(name)),
                message_encoding="protobuf",
                context=context,
            )
            for topic, name in _MESSAGES.items()
        }
        clients.greet = self._tell_time

    async def run(self) -> None:
        """Follow the run to its end; then play it again for each client that comes."""
        await self._follow()
        while True:
            await self._clients.newcomer.wait()
            await self._welcome()

    async def _welcome(self) -> None:
        await asyncio.sleep(_SETTLE_S)
        self._clients.meet()
        await self._play()

    @property
    def _stands_still(self) -> bool:
        return self._scenario is not None and self._log.is_still(still_limit_s(self._scenario))

    def _tell_time(self) -> None:
        """Send the time to a client that has come: the run's start, or that of who else watches.

        A client starts its plots at the time that it knows when it first shows the topics, and in
        1970 if it knows none. A time that goes back empties the plots of the others.
        """
        self._server.broadcast_time(self._told_ns if self._clients else EPOCH_NS)

    async def _follow(self) -> None:
        """Send what the run logs, as soon as it has logged it."""
        log, taken = self._log, 0
        from_start = True
        while not (log.whole and taken == len(log.chunks)):
            grown = log.path.exists() and log.extend()
            self._begin()
            if from_start and log.whole:
                return  # a run that had ended before; everybody sees it from its start
            from_start = False
            for place in log.chunks[taken:]:
                taken += 1
                if self._clients:
                    self._clients.meet()
                    self._send_all(place)
                else:
                    self._learn(place)
                await asyncio.sleep(0)
            if not grown and self._stands_still and self._clients.newcomer.is_set():
                await self._welcome()  # to a log that is cut, or to a run that stands still
            elif not grown:
                await asyncio.sleep(_PAUSE_S)

    async def _play(self) -> None:
        """Send the run from its start, as fast as its time passes, while anybody watches."""
        began_ns, first_ns = wall_ns(), None
        for place in self._log.chunks:
            for topic, time_ns, payload in self._messages(place):
                first_ns = time_ns if first_ns is None else first_ns
                ahead_ns = time_ns - first_ns - (wall_ns() - began_ns)
                if ahead_ns > _TURN_NS:
                    await asyncio.sleep(ahead_ns * 1e-9)
                if not self._clients:
                    return
                self._send(topic, time_ns, payload)

    def _send_all(self, place: Place) -> None:
        for message in self._messages(place):
            self._send(*message)

    def _learn(self, place: Place) -> None:
        """Read a chunk that nobody sees, because a log names each topic once, in any chunk."""
        with suppress(LogError):
            for _ in self._log.messages(place):
                pass

    def _messages(self, place: Place) -> Iterator[tuple[str, int, bytes]]:
        """Yield topic, time and payload; a damaged chunk ends early, and `repair` names it."""
        with suppress(LogError):
            for topic, time_ns, payload in self._log.messages(place):
                yield topic, time_ns, bytes(payload)

    def _send(self, topic: str, time_ns: int, payload: bytes) -> None:
        if topic not in self._channels:
            return
        if topic == TRUTH.log_name:
            self._told_ns = time_ns
            self._server.broadcast_time(time_ns)
        self._channels[topic].log(payload, log_time=time_ns)
        if self._scene is not None:
            with suppress(DecodeError, ValueError):  # of a damaged log
                for name, drawn in self._scene.take(topic, payload).items():
                    self._channels[name].log(drawn, log_time=time_ns)

    def _begin(self) -> None:
        """Make a scene once the log says of which scenario it is, unless it has one."""
        if self._begun or not self._log.begun:
            return
        self._begun = True
        try:
            scenario = Scenario.model_validate_json(self._log.effective or b"")
        except ValidationError as error:
            raise LogError(f"{self._log.path}: its scenario is not valid") from error
        self._scenario = scenario
        if not scenario.log.scene:
            self._scene = Scene(self._stage_of(scenario))
