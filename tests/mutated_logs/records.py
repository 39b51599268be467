"""Mutations change the MCAP records of a log, and its chunks."""

from __future__ import annotations

import struct
from dataclasses import replace
from random import Random
from typing import Any, Final

from mcap.opcode import Opcode

from tests.log_surgery import (
    Record,
    chunk_of,
    chunks_among,
    content_of,
    put_together,
    record_of,
    with_content,
    with_data_crc,
)
from tests.mutated_logs.bases import Base, Mutation

_EXTREME: Final = (0, 1, 0xFF, 1 << 20, 1 << 31, 1 << 32, (1 << 63) - 1, 1 << 63, (1 << 64) - 1)


def other_opcode(base: Base, random: Random) -> bytes:
    records = base.records
    at = random.randrange(len(records))
    records[at] = records[at]._replace(opcode=random.randrange(256))
    return put_together(records)


def drop_record(base: Base, random: Random) -> bytes:
    records = base.records
    del records[random.randrange(len(records))]
    return put_together(records)


def double_record(base: Base, random: Random) -> bytes:
    records = base.records
    at = random.randrange(len(records))
    records.insert(at, records[at])
    return put_together(records)


def swap_records(base: Base, random: Random) -> bytes:
    records = base.records
    i, j = (random.randrange(len(records)) for _ in range(2))
    records[i], records[j] = records[j], records[i]
    return put_together(records)


def other_number(base: Base, random: Random) -> bytes:
    """Replace eight, four or two bytes near the start of a record by an extreme number."""
    records = base.records
    at = random.randrange(len(records))
    opcode, body = records[at]
    form = random.choice(("<Q", "<I", "<H"))
    size = struct.calcsize(form)
    start = random.randrange(max(1, min(48, len(body) - size)))
    number = struct.pack(form, random.choice(_EXTREME) % (1 << 8 * size))
    if opcode == Opcode.DATA_END and number == bytes(size):
        return base.content  # a checksum of 0 means none, and all data are unchanged
    records[at] = Record(opcode, (body[:start] + number + body[start + size :])[: len(body)])
    return put_together(records)


def records_and_chunks(base: Base) -> tuple[list[Record], list[int]]:
    records = base.records
    return records, chunks_among(records)


def drop_chunk(base: Base, random: Random) -> bytes:
    records, chunks = records_and_chunks(base)
    del records[random.choice(chunks)]
    return with_data_crc(put_together(records))


def double_chunk(base: Base, random: Random) -> bytes:
    records, chunks = records_and_chunks(base)
    at = random.choice(chunks)
    records.insert(random.choice(chunks), records[at])
    return with_data_crc(put_together(records))


def swap_chunks(base: Base, random: Random) -> bytes:
    records, chunks = records_and_chunks(base)
    i, j = (random.choice(chunks) for _ in range(2))
    records[i], records[j] = records[j], records[i]
    return with_data_crc(put_together(records))


def other_chunk_fields(base: Base, random: Random) -> bytes:
    """Change the compression, the size or the CRC of a chunk, or truncate its content."""
    records, chunks = records_and_chunks(base)
    at = random.choice(chunks)
    chunk = chunk_of(records[at])
    where = random.randrange(len(chunk.data))
    change: dict[str, Any] = random.choice(
        [
            {"compression": random.choice(("", "lz4", "zst", "gzip", "ZSTD"))},
            {"uncompressed_size": random.choice(_EXTREME)},
            {"uncompressed_crc": random.randrange(1, 1 << 32)},
            {"data": chunk.data[:where]},
        ]
    )
    records[at] = record_of(replace(chunk, **change))
    return with_data_crc(put_together(records))


def chunk_without_crc(base: Base, random: Random) -> bytes:
    """Change a byte of a chunk without CRC. It may have no effect on the unpacked content."""
    records, chunks = records_and_chunks(base)
    at = random.choice(chunks)
    chunk = chunk_of(records[at])
    where = random.randrange(len(chunk.data))
    data = chunk.data[:where] + random.randbytes(1) + chunk.data[where + 1 :]
    records[at] = record_of(replace(chunk, uncompressed_crc=0, data=data))
    return with_data_crc(put_together(records))


def other_chunk_content(base: Base, random: Random) -> bytes:
    """Change bytes of a chunk's content, with sizes and CRC that still hold."""
    records, chunks = records_and_chunks(base)
    at = random.choice(chunks)
    data = bytearray(content_of(chunk_of(records[at])))
    for _ in range(random.choice((1, 1, 10))):
        data[random.randrange(len(data))] = random.randrange(256)
    if random.random() < 0.2:
        del data[random.randrange(len(data)) :]
    records[at] = record_of(with_content(chunk_of(records[at]), bytes(data)))
    return with_data_crc(put_together(records))


RECORDS: Final = {
    "other opcode": Mutation(other_opcode),
    "record dropped": Mutation(drop_record),
    "record doubled": Mutation(double_record),
    "records swapped": Mutation(swap_records),
    "other number in a record": Mutation(other_number),
    "chunk dropped, CRC good": Mutation(drop_chunk),
    "chunk doubled, CRC good": Mutation(double_chunk),
    "chunks swapped, CRC good": Mutation(swap_chunks),
    "chunk with other fields": Mutation(other_chunk_fields),
    "chunk without a CRC": Mutation(chunk_without_crc, must_report=False),
    "chunk of other content": Mutation(other_chunk_content, must_report=False),  # also of wall time
}
