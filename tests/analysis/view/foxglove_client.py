"""A client of Foxglove's WebSocket protocol, and helpers that await what it connects to."""

from __future__ import annotations

import base64
import json
import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from tests.conftest import LIMIT_S, Command, wait_until
from zenvoy.analysis.view.growing_log import GrowingLog

_HEAD: Final = struct.Struct("<BIQ")  # opcode, subscription and log time of a message
_MESSAGE: Final = 1
_A_TIME: Final = 2
_TIME: Final = struct.Struct("<BQ")


class FoxgloveClient:
    """A client that subscribes to topics and decodes their messages by the advertised schemas."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self.server = self._next("serverInfo")
        self.channels: dict[str, dict[str, Any]] = {}
        while "/fleet/summary" not in self.channels:
            found = self._next("advertise")["channels"]
            self.channels |= {channel["topic"]: channel for channel in found}
        self._classes: dict[int, tuple[str, Any]] = {}

    def subscribe(self, *topics: str) -> None:
        """Subscribe to topics."""
        rows = []
        for number, topic in enumerate(topics):
            channel = self.channels[topic]
            self._classes[number] = (topic, decoder(channel))
            rows.append({"id": number, "channelId": channel["id"]})
        self._connection.send(json.dumps({"op": "subscribe", "subscriptions": rows}))

    def messages(self) -> Iterator[tuple[str, int, Any]]:
        """Yield topic, log time and decoded message."""
        while True:
            frame = self._connection.recv(LIMIT_S)
            if isinstance(frame, bytes) and frame[0] == _MESSAGE:
                _, number, time_ns = _HEAD.unpack_from(frame)
                topic, of = self._classes[number]
                yield topic, time_ns, of.FromString(frame[_HEAD.size :])

    def time_on_coming(self) -> int:
        """Ask for parameters, as Studio does first; return the time (ns) that comes then."""
        ask = {"op": "getParameters", "parameterNames": [], "id": "all"}
        self._connection.send(json.dumps(ask))
        while True:
            frame = self._connection.recv(LIMIT_S)
            if isinstance(frame, bytes) and frame[0] == _A_TIME:
                return int(_TIME.unpack(frame)[1])

    def _next(self, op: str) -> dict[str, Any]:
        while True:
            frame = self._connection.recv(LIMIT_S)
            if isinstance(frame, str) and (found := json.loads(frame))["op"] == op:
                return dict(found)


def decoder(channel: dict[str, Any]) -> Any:
    """Return the class of a channel's messages, by the schema that it was advertised with."""
    assert (channel["encoding"], channel["schemaEncoding"]) == ("protobuf", "protobuf")
    return class_by(channel["schemaName"], base64.b64decode(channel["schema"]))


def class_by(name: str, schema: bytes) -> Any:
    """Return the class of a message by a schema."""
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(schema).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(name))


def address_in(server: Command) -> str:
    wait_until(lambda: "ws://" in server.out, "the address of the server is printed")
    found = re.search(r"ws://127\.0\.0\.1:\d+", server.out)
    assert found is not None
    return found[0]


@contextmanager
def client_at(address: str) -> Iterator[FoxgloveClient]:
    with connect(address, subprotocols=[Subprotocol("foxglove.sdk.v1")], max_size=None) as opened:
        yield FoxgloveClient(opened)


def wait_for_chunks(path: Path) -> None:
    """Wait until a run has logged for a while."""
    log = GrowingLog(path)
    wait_until(lambda: path.exists() and log.extend() and len(log.chunks) > 3, "it runs")
