"""Requests to end: SIGINT, SIGTERM and SIGHUP, and what becomes of them."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Final

REQUESTS_TO_END: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

Handler = Callable[[int, FrameType | None], None]


def requests_to_end() -> Sequence[signal.Signals]:
    """Return the signals that ask this process to end, except those it was started to ignore.

    Python handles signals in the main thread alone: elsewhere there are none.
    """
    if threading.current_thread() is not threading.main_thread():
        return ()
    return [number for number in REQUESTS_TO_END if signal.getsignal(number) != signal.SIG_IGN]


@contextmanager
def interruptible() -> Iterator[None]:
    """Let a request to end raise KeyboardInterrupt; elsewhere it ends the command on the spot.

    For what has something to tidy up.
    """
    with requests_to_end_handled_by(_interrupt):
        yield


@contextmanager
def requests_to_end_handled_by(handler: Handler) -> Iterator[None]:
    """Install a handler for the requests to end, and the earlier ones again at the end."""
    numbers = requests_to_end()
    before = [signal.signal(number, handler) for number in numbers]
    try:
        yield
    finally:
        for number, earlier in zip(numbers, before, strict=True):
            signal.signal(number, earlier)


@contextmanager
def requests_held() -> Iterator[None]:
    """Hold requests to end until the context is left.

    What a signal's handler raises inside a hook of fork is ignored, and the request is lost.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, REQUESTS_TO_END)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
