"""Takes logs apart and puts them together again: as records of MCAP, and as messages."""

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

from tests.conftest import Log, Logged

_HEAD: Final = struct.Struct("<BQ")


class Record(NamedTuple):
    """A record as it stands in the file."""

    opcode: int
    body: bytes


def taken_apart(content: bytes) -> list[Record]:
    """Records of a file that is whole, or up to its cut."""
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
    """A file of records, with both its ends; no checksum is made good."""
    parts = [_HEAD.pack(opcode, len(body)) + body for opcode, body in records]
    return MCAP0_MAGIC + b"".join(parts) + MCAP0_MAGIC


def with_data_crc(content: bytes) -> bytes:
    """The file with a CRC of its data section that holds."""
    records, at = [], len(MCAP0_MAGIC)
    for record in taken_apart(content):
        if record.opcode == Opcode.DATA_END:
            records.append(Record(record.opcode, struct.pack("<I", zlib.crc32(content[:at]))))
        else:
            records.append(record)
        at += _HEAD.size + len(record.body)
    return put_together(records)


def chunks_among(records: Iterable[Record]) -> list[int]:
    """Which of the records are chunks, by their indices."""
    return [i for i, record in enumerate(records) if record.opcode == Opcode.CHUNK]


def chunk_of(record: Record) -> Chunk:
    """The chunk that a record is."""
    chunk: Chunk = Chunk.read(ReadDataStream(BytesIO(record.body)))
    return chunk


def record_of(chunk: Chunk) -> Record:
    """The record of a chunk."""
    builder = RecordBuilder()
    chunk.write(builder)
    return Record(Opcode.CHUNK, bytes(builder.end())[_HEAD.size :])


def with_content(chunk: Chunk, data: bytes) -> Chunk:
    """The chunk with other records in it, and sizes and CRC that fit."""
    return replace(
        chunk,
        data=zstandard.compress(data),
        uncompressed_size=len(data),
        uncompressed_crc=zlib.crc32(data),
        compression="zstd",
    )


def content_of(chunk: Chunk) -> bytes:
    """Records in a chunk."""
    return zstandard.decompress(chunk.data, chunk.uncompressed_size)


Change = Callable[[int, Logged], Iterable[Logged]]


def add_beside(writer: Any, log: Log) -> None:
    """Write what a log holds beside its messages: metadata and attachments."""
    for name, metadata in log.metadata.items():
        writer.add_metadata(name, metadata)
    for name, data in log.attachments.items():
        writer.add_attachment(1, 1, name, "", data)


def written_anew(
    log: Log,
    change: Change = lambda _, message: (message,),
    *,
    compression: CompressionType = CompressionType.ZSTD,
    chunked: bool = True,
    chunk_size: int = 1 << 20,
) -> bytes:
    """The log as another tool would write it: well formed, each message put through `change`."""
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
