"""Turns a request to end, and a lack of progress, into exceptions, but only at blocking waits.

Only an exception from a signal handler can interrupt a blocking receive. It must not interrupt
anything else, such as the writing of a record. So handlers raise only while the process waits;
otherwise the signal is remembered.
"""

from __future__ import annotations

import math
import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import NamedTuple, Self, TypeVar

from zenvoy.bus.clock import wall_ns
from zenvoy.bus.errors import StalledError, StoppedError

T = TypeVar("T")

_CHECKS_PER_LIMIT = 20
_IDLE_S = 0.5
_GRACE_S = 5.0  # from the request to end until the alarm kills the process


class Blame(NamedTuple):
    """What a process waits for, in words, and the processes that should send it."""

    text: str
    culprits: tuple[str, ...] = ()


class Watch:
    """Watches the main thread of a process; SIGTERM is the request to end.

    SIGTERM may be blocked until the context is entered; an earlier request is handled then. If
    `stall_limit_s` is None, a wait may last for ever. `blame` returns what is missing. It may
    return None if another process should report the stall; its argument is True once twice the
    limit has passed, so that the other process has had its chance. `on_idle` is called repeatedly
    during long waits; a request to end takes effect after it, or in a `wait` of its own.
    """

    def __init__(
        self,
        stall_limit_s: float | None,
        blame: Callable[[bool], Blame | None],
        on_idle: Callable[[], None] = lambda: None,
    ) -> None:
        self._limit_s = stall_limit_s
        self._blame = blame
        self._on_idle = on_idle
        self._waiting = False
        self._stopped = False
        self._progress = 0
        self._seen = (0, wall_ns())
        self._every_ns = round(1e9 * min(_IDLE_S, (stall_limit_s or math.inf) / _CHECKS_PER_LIMIT))
        self._alarm_ns = wall_ns()

    def __enter__(self) -> Self:
        signal.signal(signal.SIGTERM, self._on_stop)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM,))
        every_s = self._every_ns * 1e-9
        self._alarm_ns = wall_ns()
        signal.signal(signal.SIGALRM, self._on_alarm)
        signal.setitimer(signal.ITIMER_REAL, every_s, every_s)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if not self._stopped:
            signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # the process is ending already

    def wait(self, receive: Callable[[], T]) -> T:
        """Return the result of a blocking call; raises StoppedError or StalledError during it."""
        self._waiting = True
        try:
            if self._stopped:
                raise StoppedError("asked to end")
            return receive()
        finally:
            self._waiting = False

    def progressed(self) -> None:
        """Note that a barrier was met."""
        self._progress += 1

    def ignore_stalls(self) -> None:
        """Stop watching for a lack of progress."""
        if not self._stopped:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def _on_stop(self, _signal: int, _frame: FrameType | None) -> None:
        self._stopped = True
        # Set the timer first: without the handler, an alarm of the watch would end the process.
        signal.setitimer(signal.ITIMER_REAL, _GRACE_S)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)  # from now on the alarm ends the process
        if self._waiting:
            raise StoppedError("asked to end")

    def _on_alarm(self, _signal: int, _frame: FrameType | None) -> None:
        if self._stopped:
            return
        progress, since_ns = self._seen
        now_ns = wall_ns()
        # Time in which this process itself was stopped, for example by Ctrl-Z, does not count.
        since_ns += max(0, now_ns - self._alarm_ns - 2 * self._every_ns)
        self._seen, self._alarm_ns = (progress, since_ns), now_ns
        if progress != self._progress:
            self._seen = (self._progress, now_ns)
            return
        if not self._waiting:
            return
        self._waiting = False  # a request to end must not interrupt the writing of a record here
        self._on_idle()
        self._waiting = True
        if self._stopped:
            raise StoppedError("asked to end")
        if self._limit_s is not None and now_ns - since_ns > self._limit_s * 1e9:
            missing = self._blame(now_ns - since_ns > 2 * self._limit_s * 1e9)
            if missing is not None:
                raise StalledError(
                    f"no progress for {self._limit_s:g} s, waiting for {missing.text}",
                    missing.culprits,
                )
