"""Unpacks the chunks of an MCAP file, within bounds that the file cannot change.

The `mcap` package trusts the sizes in a file: a chunk of 100 kB may ask for gigabytes. Here a
wrong size is damage, and no more is unpacked than a log can hold.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Final

import lz4.frame
import zstandard
from mcap.records import Chunk

HEAD: Final = struct.Struct("<BQ")
"""The head of a record: its opcode and its length."""
MESSAGE: Final = struct.Struct("<HIQQ")
"""The fields of a message before its payload: channel, sequence, log time, publish time."""
_UNKNOWN: Final = -1  # what zstandard returns for a frame that does not state its size


class DamageError(Exception):
    """Part of a file is not what it claims to be."""


def unpacked(chunk: Chunk, limit: int) -> bytes:
    """Return the records in a chunk; raises DamageError, also for more than `limit` bytes."""
    size = chunk.uncompressed_size
    if size > limit:
        raise DamageError(f"a chunk says it unpacks to {size} bytes; at most {limit} are read")
    try:
        data = _unpacked(chunk, size)
    except (zstandard.ZstdError, RuntimeError, EOFError) as error:  # lz4 raises the latter two
        raise DamageError(f"a chunk cannot be unpacked: {error}") from error
    if len(data) != size:
        raise DamageError(f"a chunk unpacks to {len(data)} bytes, not to {size} as it says")
    if chunk.uncompressed_crc not in {0, zlib.crc32(data)}:
        raise DamageError("a chunk does not match its CRC")
    return data


def records_in(data: bytes) -> Iterator[tuple[int, memoryview]]:
    """Yield opcode and content of each record in an unpacked chunk; raises DamageError."""
    view, at = memoryview(data), 0
    while at < len(data):
        opcode, length = HEAD.unpack_from(data, at)
        start = at + HEAD.size
        at = start + length
        if opcode == 0 or at > len(data):
            raise DamageError(f"in a chunk, a record of kind {opcode} and {length} bytes")
        yield opcode, view[start:at]


def _unpacked(chunk: Chunk, size: int) -> bytes:
    """Unpack a chunk, or at most one byte more than `size` of it."""
    if chunk.compression == "":
        return chunk.data
    if chunk.compression == "zstd":
        claimed = zstandard.frame_content_size(chunk.data)
        if claimed not in {_UNKNOWN, size}:  # zstandard would allocate this much
            raise DamageError(f"a chunk unpacks to {claimed} bytes, not to {size} as it says")
        return zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=max(1, size))
    if chunk.compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1))
    raise DamageError(f"a chunk is compressed with {chunk.compression!r}; known: zstd, lz4")
