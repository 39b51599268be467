"""Requests to end: how SIGINT, SIGTERM and SIGHUP are handled."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Final

REQUESTS_TO_END: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Handler = Callable[[int, FrameType | None], None]

_raised: Final[list[int]] = []  # requests that have raised KeyboardInterrupt in `interruptible`


def requests_to_end() -> Sequence[signal.Signals]:
    """Return the signals that ask this process to end, except those it was started to ignore.

    Only the main thread can handle signals in Python; in other threads the list is empty.
    """
    if threading.current_thread() is not threading.main_thread():
        return ()
    return [number for number in REQUESTS_TO_END if signal.getsignal(number) != signal.SIG_IGN]


@contextmanager
def interruptible() -> Iterator[None]:
    """Let a request to end raise KeyboardInterrupt, for code that has something to clean up.

    Outside this context a request ends the command at once. A library that calls back into Python
    may turn KeyboardInterrupt into an error of its own; the context raises KeyboardInterrupt then.
    """
    with requests_to_end_handled_by(_interrupt):
        try:
            yield
        except Exception as error:
            if _raised:
                raise KeyboardInterrupt from error
            raise
        finally:
            _raised.clear()


@contextmanager
def requests_to_end_handled_by(handler: Handler) -> Iterator[None]:
    """Install a handler for requests to end, and restore the earlier ones on exit.

    The handler also gets a request whose KeyboardInterrupt a library has swallowed: otherwise only
    code that handles it would come here.
    """
    numbers = requests_to_end()
    before = [signal.signal(number, handler) for number in numbers]
    try:
        while _raised and not isinstance(sys.exc_info()[1], KeyboardInterrupt):
            handler(_raised.pop(), None)
        yield
    finally:
        for number, earlier in zip(numbers, before, strict=True):
            signal.signal(number, earlier)


@contextmanager
def requests_held() -> Iterator[None]:
    """Keep requests to end until the context exits; a child forked in it has them blocked.

    Python ignores what a signal handler raises inside a fork hook, so the request would be lost. A
    thread of a library may take a signal that this thread blocks, and Python still runs the handler
    here. So handlers only take note in the meantime.
    """
    noted: list[int] = []
    before = signal.pthread_sigmask(signal.SIG_BLOCK, REQUESTS_TO_END)
    try:
        with requests_to_end_handled_by(lambda number, _: noted.append(number)):
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for number in noted:
            signal.raise_signal(number)


def _interrupt(number: int, _frame: FrameType | None) -> None:
    _raised.append(number)
    raise KeyboardInterrupt
