"""Finds where the records of an MCAP file resume after a damaged part.

Chunks, and the run's result, are recognised by the bytes near their beginning.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import BinaryIO, Final, NamedTuple

from mcap.opcode import Opcode

from zenvoy.bus.log_metadata import RESULT

_HEAD: Final = struct.Struct("<BQ")
_BLOCK: Final = 1 << 20
_OVERLAP: Final = 64  # longer than a mark and the bytes before it


class _Mark(NamedTuple):
    """Bytes that identify a kind of record, and their distance from the record's beginning."""

    kind: Opcode
    text: bytes
    at: int


def _prefixed(text: str) -> bytes:
    return struct.pack("<I", len(text)) + text.encode()


_MARKS: Final = (
    _Mark(Opcode.CHUNK, _prefixed("zstd"), 37),
    _Mark(Opcode.CHUNK, _prefixed("lz4"), 37),
    _Mark(Opcode.METADATA, _prefixed(RESULT), 9),
)


def kind_by_content(record: bytes) -> Opcode | None:
    """Return the kind of a record by its contents; None where they do not identify it."""
    for mark in _MARKS:
        if record.startswith(mark.text, mark.at):
            return mark.kind
    return None


def next_record(file: BinaryIO, start: int) -> int | None:
    """Return the first byte from `start` on where a chunk or the run's result may begin."""
    end = file.seek(0, os.SEEK_END)
    while start < end:
        file.seek(start)
        block = file.read(_BLOCK + _OVERLAP)
        for at in sorted(set(_beginnings(block))):
            if _fits(file, start + at, end):
                return start + at
        start += _BLOCK
    return None


def _beginnings(block: bytes) -> Iterator[int]:
    for mark in _MARKS:
        found = block.find(mark.text)
        while found >= 0:
            if 0 <= found - mark.at < _BLOCK:
                yield found - mark.at
            found = block.find(mark.text, found + 1)


def _fits(file: BinaryIO, at: int, end: int) -> bool:
    """Return whether a record at this byte ends within the file."""
    file.seek(at)
    _, length = _HEAD.unpack(file.read(_HEAD.size))
    return bool(at + _HEAD.size + length <= end)
