"""How the processes of a run report their end: by an exit status, and by a line through a pipe.

They use a pipe because the disk that holds their logs may be full. A process that has done its work
exits with DONE, because a process that something made exit in the middle of its work may leave 0.
"""

from __future__ import annotations

import errno
import json
import os
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Final, NamedTuple

import zenoh

STALLED: Final = 4
STOPPED: Final = 5  # by SIGTERM
EXHAUSTED: Final = 6  # out of disk, memory, threads or file descriptors
LAW_FAILED: Final = 7  # one of the scenario's own laws failed
VEHICLE_LOST: Final = 8  # a fault killed a vehicle, and the run is to end then
DONE: Final = 64

FINISHED: Final = frozenset({DONE, STOPPED, STALLED, LAW_FAILED, VEHICLE_LOST})
"""Exit statuses of a world that has finished its log."""

_SOURCE: Final = re.compile(r" at \S+\.rs:\d+\.?")  # a place in Zenoh's code
_NO_MEMORY: Final = re.compile(
    "allocation error|allocation_failed|allocate memory|failed to map segment", re.IGNORECASE
)
_MAX_TEXT: Final = 1_500  # characters; so short a line passes through the pipe in one piece
_MAX_CULPRITS: Final = 20


class Death(NamedTuple):
    """A process that ended before the run was over: its name, the cause, and the end of its log.

    `refused` says that the system refused it a resource, such as disk or memory. `complete` says
    that the run is complete all the same.
    """

    name: str
    cause: str
    tail: tuple[str, ...] = ()
    refused: bool = False
    complete: bool = False

    def __str__(self) -> str:
        return f"{self.name} {self.cause}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LastWords:
    """What a process reports about its end, besides its exit status."""

    name: str
    text: str
    culprits: tuple[str, ...] = ()
    """Processes that it waited for in vain."""


class LastWordsPipe:
    """A pipe from the processes of a run to the supervisor; it is made before the fork."""

    def __init__(self) -> None:
        self._read_fd, self._write_fd = os.pipe()
        os.set_blocking(self._read_fd, False)
        os.set_blocking(self._write_fd, False)
        self._received: dict[str, LastWords] = {}

    def close(self) -> None:
        """Close both ends."""
        os.close(self._read_fd)
        os.close(self._write_fd)

    def send(self, words: LastWords) -> None:
        """Send the last words of this process; do nothing if the pipe is full or closed."""
        line = json.dumps(asdict(words)) + "\n"
        try:
            os.write(self._write_fd, line.encode())
        except (BlockingIOError, BrokenPipeError):
            return

    def of(self, name: str) -> LastWords | None:
        """Return what the process of that name sent; call this after it has ended."""
        try:
            data = os.read(self._read_fd, 1_048_576)
        except BlockingIOError:
            data = b""
        for line in data.splitlines():
            values = json.loads(line)
            words = LastWords(**{**values, "culprits": tuple(values["culprits"])})
            self._received[words.name] = words
        return self._received.get(name)


def last_words(name: str, text: str, culprits: tuple[str, ...] = ()) -> LastWords:
    """Return last words in one line, short enough to pass through the pipe in one piece."""
    return LastWords(
        name=name, text=" ".join(text.split())[:_MAX_TEXT], culprits=culprits[:_MAX_CULPRITS]
    )


def shortage_of(error: BaseException) -> str | None:
    """Return in a line what the system refused; None for an error of another kind.

    Zenoh raises ZError if it gets no socket, and panics if it gets no thread.
    """
    if isinstance(error, OSError):
        return _of_system(error)
    if isinstance(error, MemoryError) or _lacks_memory(error):
        return "out of memory"
    if isinstance(error, RuntimeError) and "start new thread" in str(error):
        return "cannot start another thread; is memory or the number of processes limited?"
    if isinstance(error, zenoh.ZError) or type(error).__name__ == "PanicException":
        return f"Zenoh: {_SOURCE.sub('', ' '.join(str(error).split()))}"
    return None


def _lacks_memory(error: BaseException) -> bool:
    """Return whether a library lacks memory: those written in C have errors of their own for it.

    Zstandard raises ZstdError, LZ4 raises RuntimeError, and the loader of shared libraries
    raises ImportError.
    """
    kind = type(error).__name__
    if kind != "ZstdError" and not isinstance(error, RuntimeError | ImportError):
        return False
    return _NO_MEMORY.search(str(error)) is not None


def _of_system(error: OSError) -> str:
    text = error.strerror or str(error)
    if error.filename is not None:
        text += f": {error.filename}"
    hint = _HINTS.get(error.errno or 0)
    return f"{text} ({hint})" if hint else text


_HINTS: Final[dict[int, str]] = {
    errno.EMFILE: "ulimit -n",
    errno.EFBIG: "ulimit -f",
    errno.EAGAIN: "ulimit -u",
}

Send = Callable[[LastWords], None]
