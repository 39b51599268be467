"""The records of an MCAP file from front to back, also of one that is cut or damaged anywhere.

The readers of the `mcap` package raise one error or another where a file ends early, trust every
size in it, and make an object of each message. Here a record that is not all there ends the file,
sizes have bounds, and a message is a view of its chunk.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Final, NamedTuple, Self

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

from zenvoy.analysis.log.chunks import DamageError, unpacked
from zenvoy.analysis.log.resync import kind_by_content, next_record
from zenvoy.bus.log_format import chunk_limit
from zenvoy.bus.log_metadata import RUN

_HEAD: Final = struct.Struct("<BQ")  # of a record: what it is, and its length
_MESSAGE: Final = struct.Struct("<HIQQ")  # before its data
_CRC: Final = struct.Struct("<I")
_FOOTER: Final = struct.Struct("<QQI")
_PARSERS: Final[dict[int, Callable[[ReadDataStream], Any]]] = {
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.STATISTICS: Statistics.read,
}
_FIXED_LENGTH: Final = {int(Opcode.DATA_END): _CRC.size, int(Opcode.FOOTER): _FOOTER.size}
_LARGEST: Final = 64 << 20  # bytes of an attachment, or of any other record that is not a chunk
_FLEET: Final = 1_000  # vehicles, where the log does not say yet
_BLOCK: Final = 1 << 20
_PEEK: Final = 64
_BROKEN: Final = (DamageError, McapError, struct.error, ValueError, OverflowError)


class LogError(Exception):
    """A file that is no log of a run, or of which nothing can be read."""


class Message(NamedTuple):
    """A message of a log. Its payload is a view of a chunk and keeps it in memory."""

    topic: str
    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    payload: memoryview


class Pass:
    """One pass over a log; use as a context, and read `messages` to their end.

    Then `metadata`, `attachments`, `channels` and `statistics` are what was found, `whole` says
    whether the file has the end that it should have, and `faults` what does not hold of what was
    checked on the way. Raises LogError for a file that is no MCAP file or cannot be read, and at
    the first part that is damaged; with `salvage`, that part is a fault, and reading goes on after
    it. With `check`, every byte is read for the sake of the checksums over whole sections.
    """

    def __init__(self, path: Path, *, check: bool = False, salvage: bool = False) -> None:
        self._path = path
        self._check = check
        self._salvage = salvage
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, Attachment] = {}
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.statistics: Statistics | None = None
        self.whole = False
        self.faults: list[str] = []
        self.found: Counter[int] = Counter()
        """Records in the data section by opcode."""
        self.counts: Counter[int] = Counter()
        """Messages by channel."""
        self.data_crc: bool | None = None
        """Whether the CRC of the data section holds; None: there is none."""
        self.summary_crc: bool | None = None
        self._crc = 0
        self._in_summary = False

    def __enter__(self) -> Self:
        try:
            if not self._path.is_file() and not self._path.is_dir() and self._path.exists():
                raise LogError(f"{self._path}: not a regular file")
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

    @property
    def topics(self) -> dict[int, str]:
        """Topics by channel."""
        return {number: channel.topic for number, channel in self.channels.items()}

    def messages(self, topics: Collection[str] | None) -> Iterator[Message]:
        """Messages of `topics` in the order of the file; None: of all.

        Copy of a payload what is to be kept.
        """
        size = self._file.seek(0, os.SEEK_END)
        self._file.seek(0)
        if self._read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
            raise LogError(f"{self._path}: not an MCAP file")
        at = len(MCAP0_MAGIC)
        while at + _HEAD.size <= size and not self.whole:
            try:
                end = self._head(at, size)
                if end is None:
                    return
                for message in self._record(end):
                    self.counts[message.channel] += 1
                    if topics is None or message.topic in topics:
                        yield message
                at = end
            except _BROKEN as error:
                at = self._damaged(at, size, str(error) or type(error).__name__)

    def _head(self, at: int, size: int) -> int | None:
        """Read what a record is; where it ends, or None where the file is cut in it."""
        self._crc_before = self._crc
        self._opcode, length = _HEAD.unpack(self._read(_HEAD.size))
        end = at + _HEAD.size + length
        if end > size or self._opcode == 0:  # zeros: where a copy was not finished
            if self._is_cut(at, size):
                return None
            raise DamageError(f"a record of kind {self._opcode} and {length} bytes")
        if self._salvage:
            self._file.seek(at)
            kind = kind_by_content(self._file.read(_PEEK))
            if kind is not None and kind != self._opcode:
                self.faults.append(f"a {kind.name.lower()} at byte {at} bears the wrong kind")
                self._opcode = kind
            self._file.seek(at + _HEAD.size)
        return int(end)

    def _is_cut(self, at: int, size: int) -> bool:
        """Whether nothing of the log follows a record that is not whole."""
        if self._salvage:
            return next_record(self._file, at + 1) is None
        self._file.seek(size - len(MCAP0_MAGIC))
        return self._file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC

    def _record(self, end: int) -> Iterator[Message]:
        """Take in the rest of a record; the messages in it."""
        length = end - self._file.tell()
        if not self._in_summary:
            self.found[self._opcode] += 1
        if _FIXED_LENGTH.get(self._opcode, length) != length:
            raise DamageError(f"a record of kind {self._opcode} and {length} bytes")
        if self._opcode in _PARSERS or self._opcode == Opcode.MESSAGE:
            limit = self._limit() if self._opcode in {Opcode.CHUNK, Opcode.MESSAGE} else _LARGEST
            if length > limit:
                raise DamageError(f"a record of {length} bytes; at most {limit} are read")
            yield from self._take(self._opcode, memoryview(self._read(length)))
        elif self._opcode == Opcode.DATA_END:
            told = _CRC.unpack(self._read(length))[0]
            self.data_crc = told == self._crc_before if self._check and told else None
            self._in_summary, self._crc = True, 0
        elif self._opcode == Opcode.FOOTER:
            told = _FOOTER.unpack(self._read(length, but_last=_CRC.size))[2]
            self.summary_crc = told == self._crc if self._check and told else None
            self.whole = self._file.read(len(MCAP0_MAGIC)) == MCAP0_MAGIC
            after = self._file.read(1)
            if self.whole and after:
                self.faults.append("something stands after the end of the log")
        else:
            self._pass_over(length)

    def _take(self, opcode: int, body: memoryview) -> Iterator[Message]:
        """Note what a record says; the messages in it."""
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time_ns, publish_time_ns = _MESSAGE.unpack_from(body)
            if channel in self.channels:
                topic, payload = self.channels[channel].topic, body[_MESSAGE.size :]
                yield Message(topic, channel, sequence, log_time_ns, publish_time_ns, payload)
            else:
                self.counts[channel] += 1
            return
        found = _PARSERS[opcode](ReadDataStream(BytesIO(body)))
        if isinstance(found, Metadata):
            self.metadata[found.name] = found.metadata
        elif isinstance(found, Attachment):
            self.attachments[found.name] = found
            if _CRC.unpack(body[-_CRC.size :])[0] not in {0, zlib.crc32(body[: -_CRC.size])}:
                self.faults.append(f"attachment {found.name!r} does not match its CRC")
        elif isinstance(found, Statistics):
            self.statistics = found
        elif isinstance(found, Schema):
            self.schemas[found.id] = found
        elif isinstance(found, Channel):
            self.channels[found.id] = found
        else:
            yield from self._of_chunk(unpacked(found, self._limit()))

    def _of_chunk(self, data: bytes) -> Iterator[Message]:
        view, at = memoryview(data), 0
        while at < len(data):
            opcode, length = _HEAD.unpack_from(data, at)
            start = at + _HEAD.size
            at = start + length
            if opcode == 0 or at > len(data):
                raise DamageError(f"in a chunk, a record of kind {opcode} and {length} bytes")
            if opcode in {Opcode.MESSAGE, Opcode.CHANNEL, Opcode.SCHEMA}:
                yield from self._take(opcode, view[start:at])

    def _limit(self) -> int:
        """Bytes that a chunk may unpack to."""
        vehicles = self.metadata.get(RUN, {}).get("vehicles", "")
        return chunk_limit(int(vehicles) if vehicles.isascii() and vehicles.isdigit() else _FLEET)

    def _damaged(self, at: int, size: int, what: str) -> int:
        """Note damage of the record at a byte; where to go on. Raises LogError."""
        if not self._salvage:
            raise LogError(
                f"{self._path}: damaged at byte {at}: {what}; "
                "zenvoy repair --salvage makes a log of what can be read"
            )
        after = next_record(self._file, at + 1) or size
        self.faults.append(f"damaged from byte {at} to byte {after}: {what}")
        self._file.seek(after)
        return after

    def _read(self, length: int, but_last: int = 0) -> bytes:
        """Bytes of the file, which the running CRC takes in; raises DamageError at its end."""
        data = self._file.read(length)
        if len(data) < length and self._file.tell() > len(MCAP0_MAGIC):
            raise DamageError("the file has become shorter")
        if self._check:
            self._crc = zlib.crc32(memoryview(data)[: len(data) - but_last], self._crc)
        return data

    def _pass_over(self, length: int) -> None:
        if not self._check:
            self._file.seek(length, os.SEEK_CUR)
            return
        while length > 0:
            length -= len(self._read(min(length, _BLOCK)))
