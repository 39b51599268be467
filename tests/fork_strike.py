"""A request to end arrives during a fork, where Python ignores what a signal handler raises."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

_armed: Final[list[int]] = []


def _strike() -> None:
    if _armed:
        os.kill(os.getpid(), _armed.pop())


os.register_at_fork(before=_strike)


@contextmanager
def strike_at_fork(number: signal.Signals) -> Iterator[None]:
    """Send this process a signal during its next fork."""
    _armed.append(number)
    try:
        yield
    finally:
        _armed.clear()
