"""The records of an MCAP file from front to back, also of one that is cut anywhere.

The readers of the `mcap` package raise one error or another where a file ends early, and make an
object of each message. Here a record that is not all there ends the file, and a message is a view
of its chunk.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Collection, Iterator
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Final, Self

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Statistics
from mcap.stream_reader import get_chunk_data_stream
from mcap.writer import MCAP0_MAGIC

_HEAD: Final = struct.Struct("<BQ")  # of a record: what it is, and its length
_CHANNEL: Final = struct.Struct("<H")
_BEFORE_DATA: Final = 22  # of a message: channel, sequence, log time, publish time
_PARSERS: Final[dict[int, Callable[[ReadDataStream], Any]]] = {
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.STATISTICS: Statistics.read,
}


class LogError(Exception):
    """A file that is no log of a run, or of which nothing can be read."""


class Pass:
    """One pass over a log; use as a context, and read `messages` to their end.

    Then `metadata`, `attachments`, `channels` (topics by number) and `statistics` are what was
    found, and `whole` says whether the file has the end that it should have. Raises LogError for
    a file that is no MCAP file, cannot be read or is damaged otherwise than by a cut.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, bytes] = {}
        self.channels: dict[int, str] = {}
        self.statistics: Statistics | None = None
        self.whole = False
        self.chunks = 0

    def __enter__(self) -> Self:
        try:
            self._file: BinaryIO = self._path.open("rb")
        except OSError as error:
            raise LogError(f"{self._path}: {error.strerror}") from error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()
        if isinstance(error, OSError):
            raise LogError(f"{self._path}: {error.strerror}") from error

    def messages(self, topics: Collection[str] | None) -> Iterator[tuple[str, memoryview]]:
        """Topic and payload of each message of `topics` in the order of the file; None: of all.

        A payload is a view of a chunk and keeps it in memory: copy what is to be kept. With no
        topics the chunks are passed over, which is fast.
        """
        size = self._file.seek(0, os.SEEK_END)
        self._file.seek(0)
        if self._file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise LogError(f"{self._path}: not an MCAP file")
        wanted: set[int] = set()
        at = len(MCAP0_MAGIC)
        while at + _HEAD.size <= size and not self.whole:
            opcode, length = _HEAD.unpack(self._file.read(_HEAD.size))
            at += _HEAD.size + length
            if opcode == 0 or at > size:  # zeros where a copy was not finished, or a cut
                return
            if opcode == Opcode.CHUNK and topics is not None and not topics:
                self.chunks += 1
                self._file.seek(at)
            elif opcode in _PARSERS or opcode == Opcode.MESSAGE:
                body = self._file.read(length)
                try:
                    yield from self._take(opcode, body, topics, wanted)
                except (McapError, struct.error, ValueError, zstandard.ZstdError) as error:
                    what = str(error) or type(error).__name__
                    raise LogError(f"{self._path}: damaged before byte {at}: {what}") from error
            else:
                self._file.seek(at)
                self.whole = opcode == Opcode.FOOTER and self._file.read(8) == MCAP0_MAGIC

    def _take(
        self, opcode: int, body: bytes, topics: Collection[str] | None, wanted: set[int]
    ) -> Iterator[tuple[str, memoryview]]:
        """Note what a record says; the messages in it."""
        if opcode == Opcode.MESSAGE:
            yield from self._of_message(memoryview(body), wanted)
            return
        found = _parse(opcode, body)
        if isinstance(found, Metadata):
            self.metadata[found.name] = found.metadata
        elif isinstance(found, Attachment):
            self.attachments[found.name] = found.data
        elif isinstance(found, Statistics):
            self.statistics = found
        elif isinstance(found, Channel):
            self.channels[found.id] = found.topic
            if topics is None or found.topic in topics:
                wanted.add(found.id)
        else:
            self.chunks += 1
            stream, length = get_chunk_data_stream(found, validate_crc=True)
            yield from self._of_chunk(stream.read(length), topics, wanted)

    def _of_chunk(
        self, data: bytes, topics: Collection[str] | None, wanted: set[int]
    ) -> Iterator[tuple[str, memoryview]]:
        view, at = memoryview(data), 0
        while at < len(data):
            opcode, length = _HEAD.unpack_from(data, at)
            at += _HEAD.size
            body = view[at : at + length]
            at += length
            if opcode == Opcode.MESSAGE:
                yield from self._of_message(body, wanted)
            elif opcode == Opcode.CHANNEL:
                yield from self._take(opcode, bytes(body), topics, wanted)

    def _of_message(self, body: memoryview, wanted: set[int]) -> Iterator[tuple[str, memoryview]]:
        channel = _CHANNEL.unpack_from(body)[0]
        if channel in wanted:
            yield self.channels[channel], body[_BEFORE_DATA:]


def _parse(opcode: int, body: bytes) -> Any:
    """Record as the `mcap` package has it."""
    return _PARSERS[opcode](ReadDataStream(BytesIO(body)))
