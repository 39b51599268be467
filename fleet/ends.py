"""How the processes of a run end, as they tell it: by their exit status, and by a line down a pipe.

A log of theirs may be where they cannot write any more, and status 0 is what a process leaves that
was made to exit in the middle of its work. So one that is done says so by a status of its own.
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
EXHAUSTED: Final = 6  # for want of disk, memory, threads or file descriptors
BROKEN: Final = 7  # by a law of the scenario's own
DONE: Final = 64

_SOURCE: Final = re.compile(r" at \S+\.rs:\d+\.?")  # where in Zenoh's code
_MOST_TEXT: Final = 1_500  # characters, so that a line goes down the pipe in one piece
_MOST_CULPRITS: Final = 20


class Death(NamedTuple):
    """A process that ended before the run was over: its name, its fate, and the end of its log.

    `refused` where the system refused it what it needs, such as disk or memory; `complete` where it
    had done its part, and the run is complete all the same.
    """

    name: str
    fate: str
    tail: tuple[str, ...] = ()
    refused: bool = False
    complete: bool = False

    def __str__(self) -> str:
        return f"{self.name} {self.fate}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LastWords:
    """What a process has to say of its end, beside its exit status."""

    name: str
    text: str
    culprits: tuple[str, ...] = ()
    """Processes that it has waited for in vain."""


class WordsPipe:
    """A pipe from the processes of a run to the one that watches them, made before the fork."""

    def __init__(self) -> None:
        self._read_fd, self._write_fd = os.pipe()
        os.set_blocking(self._read_fd, False)
        os.set_blocking(self._write_fd, False)
        self._heard: dict[str, LastWords] = {}

    def close(self) -> None:
        """Close both ends."""
        os.close(self._read_fd)
        os.close(self._write_fd)

    def tell(self, words: LastWords) -> None:
        """Say the last words of this process; nothing happens where nobody can hear them."""
        line = json.dumps(asdict(words)) + "\n"
        try:
            os.write(self._write_fd, line.encode())
        except (BlockingIOError, BrokenPipeError):
            return

    def of(self, name: str) -> LastWords | None:
        """What the process of that name has said, after it has ended."""
        try:
            data = os.read(self._read_fd, 1_048_576)
        except BlockingIOError:
            data = b""
        for line in data.splitlines():
            told = json.loads(line)
            words = LastWords(**{**told, "culprits": tuple(told["culprits"])})
            self._heard[words.name] = words
        return self._heard.get(name)


def last_words(name: str, text: str, culprits: tuple[str, ...] = ()) -> LastWords:
    """Last words that are one line and go down the pipe in one piece."""
    return LastWords(
        name=name, text=" ".join(text.split())[:_MOST_TEXT], culprits=culprits[:_MOST_CULPRITS]
    )


def want_of(error: BaseException) -> str | None:
    """What the system refused, in a line; None for an error of another kind.

    Zenoh refuses to open where it gets no socket, and panics where it gets no thread.
    """
    if isinstance(error, OSError):
        return _of_system(error)
    if isinstance(error, MemoryError):
        return "out of memory"
    if isinstance(error, RuntimeError) and "start new thread" in str(error):
        return "no further thread can be started; is memory or the number of processes limited?"
    if isinstance(error, zenoh.ZError) or type(error).__name__ == "PanicException":
        return f"Zenoh: {_SOURCE.sub('', ' '.join(str(error).split()))}"
    return None


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

Tell = Callable[[LastWords], None]
