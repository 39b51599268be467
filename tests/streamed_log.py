"""Reads logs from front to back, by the records of the format alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from io import BufferedReader, RawIOBase
from pathlib import Path
from typing import NamedTuple

from mcap.exceptions import EndOfFile
from mcap.records import Attachment, Channel, Footer, Header, Message, Metadata, Schema
from mcap.stream_reader import StreamReader


class Logged(NamedTuple):
    """A message of a log."""

    topic: str
    log_time: int
    publish_time: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Log:
    """A log that is read from front to back, or up to its cut (`whole` is False)."""

    header: Header
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: list[Logged] = field(default_factory=list)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    whole: bool = False

    def of(self, topic: str) -> list[Logged]:
        """Return the messages of one topic in the order of the file."""
        return [message for message in self.messages if message.topic == topic]

    @property
    def result(self) -> dict[str, str]:
        """Return the metadata on the end of the run."""
        return self.metadata["zenvoy.result"]


def read_log(path: Path) -> Log:
    """Read a log as a stream, up to its cut if it has one."""
    return read_stream(path.open("rb", buffering=0))


def read_stream(file: RawIOBase) -> Log:
    """Read a log from a file that may still grow, and close the file."""
    with _WholeReads(file) as stream:
        records = iter(StreamReader(stream).records)
        header = next(records)
        assert isinstance(header, Header)
        log, whole = Log(header), False
        try:
            for record in records:
                _take(log, record)
                whole = whole or isinstance(record, Footer)
        except EndOfFile:
            pass
    return Log(
        log.header,
        log.schemas,
        log.channels,
        log.messages,
        log.metadata,
        log.attachments,
        whole,
    )


class _WholeReads(BufferedReader):
    """A file that says so where it ends inside a record.

    The reader of the package takes what is there for the whole record. If the file grows before it
    reads on, the part passes for a damaged record.
    """

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        if size is not None and len(data) < size:
            raise EndOfFile
        return data


def _take(log: Log, record: object) -> None:
    if isinstance(record, Schema):
        log.schemas[record.id] = record
    elif isinstance(record, Channel):
        log.channels[record.id] = record
    elif isinstance(record, Message):
        topic = log.channels[record.channel_id].topic
        log.messages.append(Logged(topic, record.log_time, record.publish_time, record.data))
    elif isinstance(record, Metadata):
        log.metadata[record.name] = record.metadata
    elif isinstance(record, Attachment):
        log.attachments[record.name] = record.data
