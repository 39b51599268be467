"""A log as a file of bytes, with a running CRC over what is read of a section."""

from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import BinaryIO, Final

from zenvoy.analysis.log.chunks import DamageError

_BLOCK: Final = 1 << 20


class LogFile:
    """A file that is read from front to back.

    With `check`, `crc` is the CRC of all bytes since it was last set to 0, and `skip` reads the
    bytes that it passes over. Raises OSError where the file cannot be opened or read.
    """

    def __init__(self, path: Path, *, check: bool) -> None:
        self.stream: BinaryIO = path.open("rb")
        self.size = self.stream.seek(0, os.SEEK_END)
        self.stream.seek(0)
        self.crc = 0
        self._check = check

    def close(self) -> None:
        """Close the file."""
        self.stream.close()

    def read(self, length: int, *, outside_crc: int = 0) -> bytes:
        """Read bytes into the CRC, except the last `outside_crc`; raises DamageError at the end."""
        data = self.stream.read(length)
        if len(data) < length:
            raise DamageError("the file has become shorter")
        if self._check:
            self.crc = zlib.crc32(memoryview(data)[: length - outside_crc], self.crc)
        return data

    def skip(self, length: int) -> None:
        """Pass over bytes; raises DamageError at the end of the file."""
        if not self._check:
            self.stream.seek(length, os.SEEK_CUR)
            return
        while length > 0:
            length -= len(self.read(min(length, _BLOCK)))

    def peek(self, at: int, length: int) -> bytes:
        """Return up to `length` bytes from byte `at` on; neither position nor CRC change."""
        position = self.stream.tell()
        self.stream.seek(at)
        data = self.stream.read(length)
        self.stream.seek(position)
        return data
