"""An MCAP writer whose memory does not grow with the log, and that checks all it can be checked by.

The `mcap` package keeps an object for each chunk until the file ends: about 700 bytes each, a
megabyte in every 20,000 cycles of 40 vehicles. Here they are kept as the bytes that they will be
in the file, compressed: about 50 bytes each.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from typing import IO, Final

import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.records import ChunkIndex
from mcap.writer import Writer

from zenvoy.bus.log_format import CHUNK_BYTES

_TOGETHER: Final = 128  # indexes that are compressed as one block
_HEAD: Final = 9  # bytes of a record before its content
_KEPT_IN: Final = "_Writer__chunk_indices"  # the package's own list; no option sets it


class LogWriter(Writer):
    """A writer of logs: zstd, with a CRC of each chunk, of the data section and of the summary."""

    def __init__(self, file: IO[bytes]) -> None:
        super().__init__(file, chunk_size=CHUNK_BYTES, enable_crcs=True, enable_data_crcs=True)
        if getattr(self, _KEPT_IN) != []:
            raise TypeError("mcap keeps the index of its chunks elsewhere")
        setattr(self, _KEPT_IN, ChunkIndexes())


class ChunkIndexes:
    """A list of chunk indexes that can be appended to and read through."""

    def __init__(self) -> None:
        self._blocks: list[bytes] = []
        self._open = RecordBuilder()
        self._in_open = 0

    def append(self, index: ChunkIndex) -> None:
        """Keep an index."""
        index.write(self._open)
        self._in_open += 1
        if self._in_open == _TOGETHER:
            self._blocks.append(zstandard.compress(self._end_open()))
            self._in_open = 0

    def __iter__(self) -> Iterator[ChunkIndex]:
        opened = self._end_open()
        self._open.write(opened)
        for block in (*map(zstandard.decompress, self._blocks), opened):
            stream = ReadDataStream(BytesIO(block))
            while stream.count < len(block):
                stream.read(_HEAD)
                yield ChunkIndex.read(stream)

    def _end_open(self) -> bytes:
        return bytes(self._open.end())

    @property
    def nbytes(self) -> int:
        """What is kept, bytes."""
        return sum(map(len, self._blocks)) + self._open.count
