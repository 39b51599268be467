"""Finds the chunks of a log without unpacking them, also of one that is still being written."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata
from mcap.writer import MCAP0_MAGIC

from zenvoy.analysis.log.chunks import HEAD, MESSAGE, DamageError, records_in, unpacked
from zenvoy.analysis.log.records import CUT_EARLY, LogError
from zenvoy.bus.clock import age_s
from zenvoy.bus.log_format import EFFECTIVE, chunk_limit
from zenvoy.bus.log_metadata import RESULT, RUN
from zenvoy.scenarios import Scenario

_TIMES: Final = struct.Struct("<QQ")  # of the first and last message, where a chunk record begins
_MAX_RECORD_BYTES: Final = 64 << 20  # of any record but chunks


STILL_S: Final = 10.0
"""How long a log must not have grown, at least, before its run may have ended without an end."""


def still_limit_s(scenario: Scenario) -> float:
    """Return how long the log of a run may not grow while the run goes on."""
    between_s = 2e-9 * scenario.period_ns / scenario.speed if scenario.clock == "realtime" else 0.0
    return STILL_S + max(between_s, scenario.stall_limit_s)


class Place(NamedTuple):
    """A chunk: where its record begins and how long it is (bytes), and its first and last time."""

    at: int
    length: int
    first_ns: int
    last_ns: int


class GrowingLog:
    """The chunks, the metadata and the scenario of a log, as far as it has been written.

    `extend` reads on where it stopped. A record that is not complete yet stays for the next time.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.chunks: list[Place] = []
        self.metadata: dict[str, dict[str, str]] = {}
        self.effective: bytes | None = None
        self.topics: dict[int, str] = {}
        """Topics by channel, as far as channels have been read."""
        self.whole = False
        """Whether the log has its end, and will not grow any more."""
        self.loose = False
        """Whether messages stand outside chunks, where they are not looked for."""
        self._at = 0
        self._modified_ns: int | None = None

    @property
    def vehicles(self) -> int:
        """Number of vehicles; 0 while it is not known."""
        text = self.metadata.get(RUN, {}).get("vehicles", "")
        return int(text) if text.isdecimal() else 0

    @property
    def begun(self) -> bool:
        """Whether metadata and scenario of the run have been written."""
        return RUN in self.metadata and self.effective is not None

    @property
    def ended(self) -> bool:
        """Whether the run has ended, by what its log says."""
        return RESULT in self.metadata

    def is_still(self, limit_s: float = STILL_S) -> bool:
        """Return whether the log has no end and has not grown for so long, when last looked at."""
        known = self._modified_ns is not None and not self.whole
        return known and age_s(self._modified_ns or 0) > limit_s

    def first_look(self) -> None:
        """Read on, before anybody looks; raises LogError for a log that will never begin, too."""
        self.extend()
        if self.is_still() and not self.begun:
            raise LogError(f"{self.path}: {CUT_EARLY}")

    def extend(self) -> bool:
        """Read what has been added to the file; return whether anything was.

        Raises LogError for a file that cannot be read, is no MCAP file, or is damaged, and for one
        that has ended and is not the log of a run.
        """
        before = self._at
        try:
            with self.path.open("rb") as file:
                size = file.seek(0, os.SEEK_END)
                self._modified_ns = os.fstat(file.fileno()).st_mtime_ns
                if self._at == 0:
                    self._at = self._begin(file)
                while self._at and not self.whole and self._at + HEAD.size <= size:
                    file.seek(self._at)
                    opcode, length = HEAD.unpack(file.read(HEAD.size))
                    start = self._at + HEAD.size
                    if opcode == 0 or start + length > size:
                        break  # a record that is not complete, or a file that is cut
                    self._look(file, opcode, start, length)
                    self._at = start + length
        except OSError as error:
            raise LogError(f"{self.path}: {error.strerror}") from error
        except (DamageError, McapError, struct.error, ValueError) as error:
            raise LogError(f"{self.path}: damaged at byte {self._at}: {error}") from error
        if self.whole and not self.begun:
            raise LogError(f"{self.path}: an MCAP file, but not the log of a run")
        return self._at > before

    def unpacked(self, place: Place) -> bytes:
        """Return the records in a chunk; raises LogError where it is damaged."""
        try:
            with self.path.open("rb") as file:
                file.seek(place.at)
                chunk = Chunk.read(ReadDataStream(BytesIO(file.read(place.length))))
            return unpacked(chunk, chunk_limit(self.vehicles))
        except OSError as error:
            raise LogError(f"{self.path}: {error.strerror}") from error
        except (DamageError, McapError, struct.error, ValueError) as error:
            raise LogError(f"{self.path}: damaged at byte {place.at}: {error}") from error

    def messages(self, place: Place) -> Iterator[tuple[str, int, memoryview]]:
        """Yield topic, time (ns) and payload of each message in a chunk.

        Raises LogError where the chunk is damaged.
        """
        try:
            for opcode, content in records_in(self.unpacked(place)):
                if opcode == Opcode.CHANNEL:
                    channel = Channel.read(ReadDataStream(BytesIO(content)))
                    self.topics[channel.id] = channel.topic
                elif opcode == Opcode.MESSAGE:
                    number, _, log_ns, _ = MESSAGE.unpack_from(content)
                    yield self.topics.get(number, ""), log_ns, content[MESSAGE.size :]
        except (DamageError, McapError, struct.error, ValueError) as error:
            raise LogError(f"{self.path}: damaged at byte {place.at}: {error}") from error

    def _begin(self, file: BinaryIO) -> int:
        """Return where the records begin, or 0 while the file has no whole beginning.

        Raises LogError if it is no MCAP file.
        """
        file.seek(0)
        magic = file.read(len(MCAP0_MAGIC))
        if magic != MCAP0_MAGIC[: len(magic)]:
            raise LogError(f"{self.path}: not an MCAP file")
        return len(magic) if len(magic) == len(MCAP0_MAGIC) else 0

    def _look(self, file: BinaryIO, opcode: int, start: int, length: int) -> None:
        """Note a record, whose body the file reads next; raises DamageError if it is too long."""
        if opcode == Opcode.CHUNK:
            self.chunks.append(Place(start, length, *_TIMES.unpack(file.read(_TIMES.size))))
        elif opcode in {Opcode.METADATA, Opcode.ATTACHMENT, Opcode.CHANNEL}:
            if length > _MAX_RECORD_BYTES:
                raise DamageError(f"a record of {length} bytes")
            self._keep(opcode, file.read(length))
        self.loose = self.loose or opcode == Opcode.MESSAGE
        self.whole = opcode == Opcode.FOOTER

    def _keep(self, opcode: int, body: bytes) -> None:
        """Keep a record that is of use."""
        stream = ReadDataStream(BytesIO(body))
        if opcode == Opcode.METADATA:
            found = Metadata.read(stream)
            self.metadata[found.name] = found.metadata
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            self.topics[channel.id] = channel.topic
        else:
            attachment = Attachment.read(stream)
            if attachment.name == EFFECTIVE:
                self.effective = attachment.data
