"""What may happen in a fork: a request to end arrives, or the child ends at once.

Python ignores what a signal handler raises there.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

_armed: Final[list[int]] = []
_ends_at_once: Final[list[bool]] = []


def _strike() -> None:
    if _armed:
        os.kill(os.getpid(), _armed.pop())


def _end() -> None:
    if _ends_at_once:
        os._exit(1)


os.register_at_fork(before=_strike, after_in_child=_end)


@contextmanager
def strike_at_fork(number: signal.Signals) -> Iterator[None]:
    """Send this process a signal during its next fork."""
    _armed.append(number)
    try:
        yield
    finally:
        _armed.clear()


@contextmanager
def children_end_at_once() -> Iterator[None]:
    """Make every child that is forked end at once."""
    _ends_at_once.append(True)
    try:
        yield
    finally:
        _ends_at_once.clear()
