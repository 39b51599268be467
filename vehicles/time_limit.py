"""A limit of wall time on a user's own code, so that code that hangs can be named."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from types import FrameType
from typing import Final

_NONE: Final = nullcontext()


class _TimeUp(BaseException):
    """The time is up. Code that catches every Exception does not catch this."""


def time_limit(limit_s: float | None) -> AbstractContextManager[None]:
    """Return a context that raises TimeoutError in code that takes longer; None: no limit.

    Only the main thread gets signals, so there is no limit in other threads. Code that catches the
    interruption all the same is interrupted again. An earlier alarm is restored afterwards.
    """
    if limit_s is None or threading.current_thread() is not threading.main_thread():
        return _NONE
    return _limited(limit_s)


@contextmanager
def _limited(limit_s: float) -> Iterator[None]:
    ours = False  # whether the alarm that is set is the one of the limit

    def expire(number: int, frame: FrameType | None) -> None:
        # An alarm of the timer before may come late: another thread may have received its signal.
        if ours and signal.getitimer(signal.ITIMER_REAL)[0] == 0.0:
            signal.setitimer(signal.ITIMER_REAL, limit_s)
            raise _TimeUp
        if callable(before):
            before(number, frame)

    before = signal.getsignal(signal.SIGALRM)
    left_s, every_s = signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    ours = True
    try:
        yield
    except _TimeUp as interruption:
        ours = False
        text = f"took longer than {limit_s:g} s"
        raise TimeoutError(text).with_traceback(interruption.__traceback__) from None
    finally:
        ours = False
        if signal.getsignal(signal.SIGALRM) is expire:  # else a request to end has taken it over
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)
            # A timer that has just rung has nothing left, until its signal is taken.
            signal.setitimer(signal.ITIMER_REAL, left_s or every_s, every_s)
