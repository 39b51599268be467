"""Finds out why a process of a run has ended, from its exit code, its last words and its log."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

from zenvoy.fleet.ends import (
    EXHAUSTED,
    LAW_FAILED,
    STALLED,
    STOPPED,
    VEHICLE_LOST,
    Death,
    LastWords,
    LastWordsPipe,
)
from zenvoy.fleet.spawn import Child

FROZEN: Final = "stalled: a signal or a debugger has stopped it"

_TAIL_LINES: Final = 15
_NO_MEMORY: Final = "memory allocation of "  # Zenoh prints this before it aborts


class Causes:
    """Names the causes of deaths; `frozen` returns the processes that are frozen now."""

    def __init__(self, words: LastWordsPipe, frozen: Callable[[], Sequence[str]]) -> None:
        self._words = words
        self._frozen = frozen

    def of_death(self, child: Child, code: int) -> Death:
        """Return the death of a child with this exit code; below 0 it is that of a signal."""
        name, tail = child.program.name, _tail(child.log)
        words = self._words.of(name)
        if code == -signal.SIGABRT and any(_NO_MEMORY in line for line in tail):
            return Death(name, "cannot go on: out of memory (ulimit -v)", refused=True)
        if code < 0 or code == STOPPED:
            how = "ended by SIGTERM" if code > 0 else f"killed by {signal.Signals(-code).name}"
            return Death(name, f"died: {how}", tail)
        if words is None or code not in {LAW_FAILED, VEHICLE_LOST, EXHAUSTED, STALLED}:
            return Death(name, f"died: exit status {code}", tail)
        if code == STALLED:
            return self._blame(words, tail)
        if code in {LAW_FAILED, VEHICLE_LOST}:
            (who,) = words.culprits or (name,)
            return Death(who, f"died: {words.text}")
        return Death(name, f"cannot go on: {words.text}", tail, refused=True)

    def of_bad_end(self, child: Child, code: int) -> Death:
        """Return why a child that was asked to end could not finish."""
        if code in {-signal.SIGALRM, -signal.SIGKILL}:  # by its own alarm, or by the supervisor
            return Death(child.program.name, "was killed, because it did not end in time")
        return self.of_death(child, code)

    def _blame(self, words: LastWords, tail: tuple[str, ...]) -> Death:
        """Return the death of the process that kept another waiting.

        It is a frozen process if there is one, else the first that the other one waited for.
        """
        frozen = self._frozen()
        if frozen:
            return Death(frozen[0], FROZEN)
        if not words.culprits:
            return Death(words.name, f"stalled: {words.text}", tail)
        others = f" and {len(words.culprits) - 1} more" if len(words.culprits) > 1 else ""
        return Death(f"{words.culprits[0]}{others}", f"stalled: {words.name} has made {words.text}")


def _tail(log: Path) -> tuple[str, ...]:
    try:
        return tuple(log.read_text("utf-8", errors="replace").splitlines()[-_TAIL_LINES:])
    except OSError:
        return ()
