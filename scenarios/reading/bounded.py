"""Reads regular files and standard input, with a limit on their size."""

from __future__ import annotations

import errno
import os
import stat
import sys
from dataclasses import dataclass
from typing import IO, Final

LARGEST_BYTES: Final = 16 * 2**20

STANDARD_INPUT: Final = "-"

_KINDS: Final = (
    (stat.S_ISDIR, "a folder, not a file"),
    (stat.S_ISFIFO, "a pipe, not a file; use - for standard input"),
    (stat.S_ISSOCK, "a socket, not a file"),
    (stat.S_ISCHR, "a device, not a file"),
    (stat.S_ISBLK, "a device, not a file"),
)


@dataclass(frozen=True, slots=True)
class RegularFile:
    """The file at a path, whether it exists or not."""

    path: str

    def read_bytes(self) -> bytes:
        """Return the contents; raises OSError, also if it is not a regular file or too large.

        Only a regular file is opened: opening a pipe or a device can block or have side effects.
        """
        try:
            _refuse_irregular(os.stat(self.path).st_mode)
            # Do not block: a pipe may have replaced the file in the meantime.
            handle = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
        except ValueError:  # the name has a null byte
            raise _refusal("not a valid file name") from None
        with os.fdopen(handle, "rb") as file:
            _refuse_irregular(os.fstat(handle).st_mode)
            return _bounded(file)


@dataclass(frozen=True, slots=True)
class StandardInput:
    """The standard input of the command."""

    def read_bytes(self) -> bytes:
        """Return the contents up to the end; raises OSError, also if they are too large."""
        if sys.stdin is None:
            raise _refusal("standard input is closed")
        return _bounded(sys.stdin.buffer)


def _bounded(file: IO[bytes]) -> bytes:
    data = file.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise _refusal(f"larger than the limit of {LARGEST_BYTES // 2**20} MiB")
    return data


def _refuse_irregular(mode: int) -> None:
    for is_kind, words in _KINDS:
        if is_kind(mode):
            raise _refusal(words)


def _refusal(text: str) -> OSError:
    return OSError(errno.EINVAL, text)
