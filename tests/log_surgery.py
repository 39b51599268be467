"""Helpers take logs apart into records or messages, and put them together again."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable
from dataclasses import replace
from io import BytesIO
from typing import Any, Final, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from tests.streamed_log import Log, Logged

_HEAD: Final = struct.Struct("<BQ")


class Record(NamedTuple):
    """A record as it is in the file."""

    opcode: int
    body: bytes


def taken_apart(content: bytes) -> list[Record]:
    """Return the records of a complete file, or up to its cut."""
    records, at = [], len(MCAP0_MAGIC)
    while at + _HEAD.size <= len(content) - len(MCAP0_MAGIC):
        opcode, length = _HEAD.unpack_from(content, at)
        at += _HEAD.size
        if at + length > len(content):
            break
        records.append(Record(opcode, content[at : at + length]))
        at += length
    return records


def put_together(records: Iterable[Record]) -> bytes:
    """Return a file of records, with both its ends. Checksums stay as they are."""
    parts = [_HEAD.pack(opcode, len(body)) + body for opcode, body in records]
    return MCAP0_MAGIC + b"".join(parts) + MCAP0_MAGIC


def with_data_crc(content: bytes) -> bytes:
    """Return the file with a valid CRC of its data section."""
    records, at = [], len(MCAP0_MAGIC)
    for record in taken_apart(content):
        if record.opcode == Opcode.DATA_END:
            records.append(Record(record.opcode, struct.pack("<I", zlib.crc32(content[:at]))))
        else:
            records.append(record)
        at += _HEAD.size + len(record.body)
    return put_together(records)


def chunks_among(records: Iterable[Record]) -> list[int]:
    """Return the indices of the records that are chunks."""
    return [i for i, record in enumerate(records) if record.opcode == Opcode.CHUNK]


def chunk_of(record: Record) -> Chunk:
    """Return the chunk in a record."""
    chunk: Chunk = Chunk.read(ReadDataStream(BytesIO(record.body)))
    return chunk


def record_of(chunk: Chunk) -> Record:
    """Return the record of a chunk."""
    builder = RecordBuilder()
    chunk.write(builder)
    return Record(Opcode.CHUNK, bytes(builder.end())[_HEAD.size :])


def with_content(chunk: Chunk, data: bytes) -> Chunk:
    """Return the chunk with other content, and with sizes and CRC that fit."""
    return replace(
        chunk,
        data=zstandard.compress(data),
        uncompressed_size=len(data),
        uncompressed_crc=zlib.crc32(data),
        compression="zstd",
    )


def content_of(chunk: Chunk) -> bytes:
    """Return the records in a chunk."""
    return zstandard.decompress(chunk.data, chunk.uncompressed_size)


Change = Callable[[int, Logged], Iterable[Logged]]


def add_beside(writer: Any, log: Log) -> None:
    """Write the metadata and attachments of a log."""
    for name, metadata in log.metadata.items():
        writer.add_metadata(name, metadata)
    for name, data in log.attachments.items():
        writer.add_attachment(1, 1, name, "", data)


def rewritten(
    log: Log,
    change: Change = lambda _, message: (message,),
    *,
    compression: CompressionType = CompressionType.ZSTD,
    chunked: bool = True,
    chunk_size: int = 1 << 20,
) -> bytes:
    """Return the log as another tool would write it, each message passed through `change`."""
    file = BytesIO()
    writer: Any = Writer(file, chunk_size=chunk_size, compression=compression, use_chunking=chunked)
    writer.start()
    add_beside(writer, log)
    schema = writer.register_schema("x", "protobuf", b"")
    topics: dict[str, int] = {}
    for number, message in enumerate(log.messages):
        for changed in change(number, message):
            if changed.topic not in topics:
                topics[changed.topic] = writer.register_channel(changed.topic, "", schema)
            writer.add_message(topics[changed.topic], changed.log_time, changed.data, 1)
    writer.finish()
    return file.getvalue()
