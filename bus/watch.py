"""Turns a request to end, and a lack of progress, into exceptions at blocking waits only.

A blocking receive can be left only by an exception from a signal handler, and such an exception
must not hit the middle of anything else (a half-written record): so handlers raise while the
process waits, and are remembered otherwise.
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
_GRACE_S = 5.0  # from the request to end until the system ends the process


class Blame(NamedTuple):
    """What a process waits for, in words, and the processes that it should come from."""

    text: str
    culprits: tuple[str, ...] = ()


class Watch:
    """Watches one process's main thread; SIGTERM is the request to end.

    SIGTERM may be held until the context is entered: a request from before is remembered.
    `stall_limit_s` None: wait for ever. `blame` says what is missing, or returns None
    where somebody else should be blamed, who has until twice the limit to do so: it is told
    whether that time has passed. `on_idle` is called out of a wait that has lasted for a while, and
    again and again as it goes on.
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
        signal.signal(signal.SIGTERM, signal.SIG_IGN)  # the end is on its way already

    def wait(self, receive: Callable[[], T]) -> T:
        """Result of a blocking call; raises StoppedError or StalledError out of it."""
        self._waiting = True
        try:
            if self._stopped:
                raise StoppedError("asked to end")
            return receive()
        finally:
            self._waiting = False

    def progressed(self) -> None:
        """Say that a barrier was met."""
        self._progress += 1

    def let_be(self) -> None:
        """From now on a lack of progress is no business of this watch."""
        if not self._stopped:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def _on_stop(self, _signal: int, _frame: FrameType | None) -> None:
        self._stopped = True
        signal.signal(signal.SIGALRM, signal.SIG_DFL)  # from now on the alarm is final
        signal.setitimer(signal.ITIMER_REAL, _GRACE_S)
        if self._waiting:
            raise StoppedError("asked to end")

    def _on_alarm(self, _signal: int, _frame: FrameType | None) -> None:
        progress, since_ns = self._seen
        now_ns = wall_ns()
        # Time in which this process was itself stopped, by Ctrl-Z say, is nobody's fault.
        since_ns += max(0, now_ns - self._alarm_ns - 2 * self._every_ns)
        self._seen, self._alarm_ns = (progress, since_ns), now_ns
        if progress != self._progress:
            self._seen = (self._progress, now_ns)
            return
        if not self._waiting:
            return
        self._on_idle()
        if self._limit_s is not None and now_ns - since_ns > self._limit_s * 1e9:
            missing = self._blame(now_ns - since_ns > 2 * self._limit_s * 1e9)
            if missing is not None:
                raise StalledError(
                    f"no progress for {self._limit_s:g} s, waiting for {missing.text}",
                    missing.culprits,
                )
