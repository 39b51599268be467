"""Reads what a user names: regular files and standard input, of bounded size, without waiting."""

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
    (stat.S_ISFIFO, "a pipe, not a file; what is piped in is named -"),
    (stat.S_ISSOCK, "a socket, not a file"),
    (stat.S_ISCHR, "a device, not a file"),
    (stat.S_ISBLK, "a device, not a file"),
)


@dataclass(frozen=True, slots=True)
class RegularFile:
    """The file at a path, whether it exists or not."""

    path: str

    def read_bytes(self) -> bytes:
        """Its contents. Raises OSError, also for what is no regular file, and what is too large.

        Nothing that is no regular file is opened: to open one can wait for ever, or act.
        """
        try:
            _refuse_irregular(os.stat(self.path).st_mode)
            # It may have become another one by now, which must not keep us waiting.
            handle = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
        except ValueError:  # a null byte is in no name of a file
            raise _refusal("no file has such a name") from None
        with os.fdopen(handle, "rb") as file:
            _refuse_irregular(os.fstat(handle).st_mode)
            return _bounded(file)


@dataclass(frozen=True, slots=True)
class StandardInput:
    """What is piped into the command."""

    def read_bytes(self) -> bytes:
        """Its contents, up to its end. Raises OSError, also for what is too large."""
        if sys.stdin is None:
            raise _refusal("standard input is closed")
        return _bounded(sys.stdin.buffer)


def _bounded(file: IO[bytes]) -> bytes:
    data = file.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise _refusal(f"larger than {LARGEST_BYTES // 2**20} MiB, the most that is allowed")
    return data


def _refuse_irregular(mode: int) -> None:
    for is_kind, words in _KINDS:
        if is_kind(mode):
            raise _refusal(words)


def _refusal(text: str) -> OSError:
    return OSError(errno.EINVAL, text)
