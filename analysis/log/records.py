"""Reads the records of an MCAP file from front to back, even if it is cut or damaged.

The readers of the `mcap` package raise various errors where a file ends early, trust every size in
it, and make an object of each message. Here an incomplete record ends the file, sizes are limited,
and a message is a view of its chunk.

A pass is one state over the whole file: each kind of record changes what the next may be. So its
steps share a module, although it is long.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Iterator
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import Any, Final, NamedTuple, Self

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

from zenvoy.analysis.log.chunks import HEAD, MESSAGE, DamageError, records_in, unpacked
from zenvoy.analysis.log.log_file import LogFile
from zenvoy.analysis.log.resync import kind_by_content, next_record
from zenvoy.bus.log_format import chunk_limit
from zenvoy.bus.log_metadata import RUN

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
_MAX_RECORD_BYTES: Final = 64 << 20  # of any record but chunks and messages
_ASSUMED_VEHICLES: Final = 1_000  # until the log says how many there are
_IDENTIFYING_BYTES: Final = 64  # at the beginning of a record
# What reading a damaged record may raise.
_DAMAGE_ERRORS: Final = (DamageError, McapError, struct.error, ValueError, OverflowError)


CUT_EARLY: Final = "cut before the scenario, so it cannot be read"


class LogError(Exception):
    """A file is not the log of a run, or cannot be read."""


class Message(NamedTuple):
    """A message of a log. Its payload is a view of a chunk and keeps it in memory."""

    topic: str
    channel: int
    sequence: int
    log_time_ns: int
    publish_time_ns: int
    payload: memoryview


class _Head(NamedTuple):
    """The head of a record: its opcode, the byte where it ends, and the CRC of all before it."""

    opcode: int
    end: int
    crc_before: int


class Pass:
    """One pass over a log; use it as a context, and read `messages` to their end.

    Afterwards `metadata`, `attachments`, `channels` and `statistics` hold what was found, `whole`
    says whether the file has its proper end, and `faults` lists the checks that failed. Raises
    LogError for a file that is not an MCAP file or cannot be read, and at the first damaged part.
    With `salvage`, a damaged part is a fault instead, and reading resumes after it. With `check`,
    every byte is read, to verify the checksums of whole sections.

    An MCAP file is a magic number, a data section, a summary section, a footer and the magic number
    again. Each record is an opcode, a length, and as many bytes.
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
        """Number of records in the data section, by opcode."""
        self.counts: Counter[int] = Counter()
        """Number of messages, by channel."""
        self.data_crc: bool | None = None
        """Whether the CRC of the data section holds; None where there is none."""
        self.summary_crc: bool | None = None
        """Whether the CRC of the summary section holds; None where there is none."""
        self._in_summary = False

    def __enter__(self) -> Self:
        try:
            if not self._path.is_file() and not self._path.is_dir() and self._path.exists():
                raise LogError(f"{self._path}: not a regular file")
            self._file = LogFile(self._path, check=self._check)
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
        """Yield the messages of `topics`, or of all topics for None, in the order of the file.

        Copy a payload to keep it: it is a view, and keeps its whole chunk in memory.
        """
        at, size = len(MCAP0_MAGIC), self._file.size
        if self._file.peek(0, at) != MCAP0_MAGIC:
            raise LogError(f"{self._path}: not an MCAP file")
        self._file.skip(at)
        while at + HEAD.size <= size and not self.whole:
            try:
                head = self._head(at)
                if head is None:
                    return
                for message in self._rest(head):
                    self.counts[message.channel] += 1
                    if topics is None or message.topic in topics:
                        yield message
                at = head.end
            except _DAMAGE_ERRORS as error:
                at = self._resume_after(at, str(error) or type(error).__name__)

    def _head(self, at: int) -> _Head | None:
        """Read the head of the record at a byte; None where the file is cut in this record."""
        crc_before = self._file.crc
        opcode, length = HEAD.unpack(self._file.read(HEAD.size))
        end = at + HEAD.size + length
        if end > self._file.size or opcode == 0:  # a copy that was not finished ends in zeros
            if self._is_cut(at):
                return None
            raise DamageError(f"a record of kind {opcode} and {length} bytes")
        if self._salvage:
            kind = kind_by_content(self._file.peek(at, _IDENTIFYING_BYTES))
            if kind is not None and kind != opcode:
                self.faults.append(f"a {kind.name.lower()} at byte {at} has the wrong opcode")
                opcode = kind
        return _Head(opcode, end, crc_before)

    def _is_cut(self, at: int) -> bool:
        """Return whether an incomplete record at a byte is the last thing in the file."""
        if self._salvage:
            return next_record(self._file.stream, at + 1) is None
        return self._file.peek(self._file.size - len(MCAP0_MAGIC), len(MCAP0_MAGIC)) != MCAP0_MAGIC

    def _rest(self, head: _Head) -> Iterator[Message]:
        """Read the rest of a record, and yield the messages in it."""
        opcode, length = head.opcode, head.end - self._file.stream.tell()
        if not self._in_summary:
            self.found[opcode] += 1
        if _FIXED_LENGTH.get(opcode, length) != length:
            raise DamageError(f"a record of kind {opcode} and {length} bytes")
        if opcode == Opcode.DATA_END:
            self._end_of_data(head.crc_before)
        elif opcode == Opcode.FOOTER:
            self._end_of_file()
        elif opcode in _PARSERS or opcode == Opcode.MESSAGE:
            has_messages = opcode in {Opcode.CHUNK, Opcode.MESSAGE}
            limit = self._chunk_limit() if has_messages else _MAX_RECORD_BYTES
            if length > limit:
                raise DamageError(f"a record has {length} bytes; at most {limit} are read")
            yield from self._contents(opcode, memoryview(self._file.read(length)))
        else:
            self._file.skip(length)

    def _end_of_data(self, crc: int) -> None:
        """Read the record that ends the data section, and compare its CRC; 0 stands for none."""
        (stored,) = _CRC.unpack(self._file.read(_CRC.size))
        self.data_crc = stored == crc if self._check and stored else None
        self._in_summary, self._file.crc = True, 0

    def _end_of_file(self) -> None:
        """Read footer and magic number; the summary's CRC covers the footer up to the CRC."""
        footer = self._file.read(_FOOTER.size, outside_crc=_CRC.size)
        *_, stored = _FOOTER.unpack(footer)
        self.summary_crc = stored == self._file.crc if self._check and stored else None
        end = self._file.stream.read(len(MCAP0_MAGIC) + 1)
        self.whole = end.startswith(MCAP0_MAGIC)
        if self.whole and len(end) > len(MCAP0_MAGIC):
            self.faults.append("the file goes on after the end of the log")

    def _contents(self, opcode: int, body: memoryview) -> Iterator[Message]:
        """Keep what a record holds, and yield the messages in it."""
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time_ns, publish_time_ns = MESSAGE.unpack_from(body)
            if channel in self.channels:
                topic, payload = self.channels[channel].topic, body[MESSAGE.size :]
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
            yield from self._records_of_chunk(unpacked(found, self._chunk_limit()))

    def _records_of_chunk(self, data: bytes) -> Iterator[Message]:
        """Yield the messages in an unpacked chunk."""
        for opcode, content in records_in(data):
            if opcode in {Opcode.MESSAGE, Opcode.CHANNEL, Opcode.SCHEMA}:
                yield from self._contents(opcode, content)

    def _chunk_limit(self) -> int:
        """Return how many bytes a chunk may unpack to."""
        vehicles = self.metadata.get(RUN, {}).get("vehicles", "")
        known = vehicles.isascii() and vehicles.isdigit()
        return chunk_limit(int(vehicles) if known else _ASSUMED_VEHICLES)

    def _resume_after(self, at: int, damage: str) -> int:
        """Note that the record at a byte is damaged, and return where to go on.

        Raises LogError unless the log is salvaged.
        """
        if not self._salvage:
            raise LogError(
                f"{self._path}: damaged at byte {at}: {damage}; "
                "zenvoy repair --salvage saves what can be read"
            )
        after = next_record(self._file.stream, at + 1) or self._file.size
        self.faults.append(f"damaged from byte {at} to byte {after}: {damage}")
        self._file.stream.seek(after)
        return after
