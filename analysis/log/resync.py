"""Where the records of an MCAP file go on after a part that is damaged."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import BinaryIO, Final, NamedTuple

from mcap.opcode import Opcode

from zenvoy.bus.log_metadata import RESULT

_HEAD: Final = struct.Struct("<BQ")
_BLOCK: Final = 1 << 20
_OVERLAP: Final = 64  # longer than a mark and what stands before it


class _Mark(NamedTuple):
    """What stands within a record of a kind, and how far from its beginning."""

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
    """What a record is by its first bytes, whatever kind it bears; None: cannot be told."""
    for mark in _MARKS:
        if record.startswith(mark.text, mark.at):
            return mark.kind
    return None


def next_record(file: BinaryIO, start: int) -> int | None:
    """First byte from `start` on at which a chunk or the run's result seems to begin."""
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
    """Whether a record at this byte ends within the file."""
    file.seek(at)
    _, length = _HEAD.unpack(file.read(_HEAD.size))
    return bool(at + _HEAD.size + length <= end)
