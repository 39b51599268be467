"""A machine that is stopped again and again, until its run says that it holds up the steps."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Final

import pytest

from tests.conftest import Command, wait_until
from tests.let_pass import let_pass

_PAUSE_S: Final = 3.0  # Zenoh gives up a link to a machine that is silent for 10 s
_MOST: Final = 20


def hold_up(slow: Command, name: str, served: Command, log: Path) -> None:
    """Stop a machine for most of the time until its run names it, or ends.

    One long pause is not enough on a busy machine, where the rest of the run takes long, too.
    """
    for _ in range(_MOST):
        _pause(slow, served, log)
        if served.has_ended() or f"on {name} held up" in served.out:
            return
    pytest.fail(
        f"after {_MOST} pauses {name} is not said to hold up the run, which says: {served.out}"
    )


def _pause(slow: Command, served: Command, log: Path) -> None:
    """Stop a machine for a time, and return when the run has gone on."""
    try:
        slow.send_to_group(signal.SIGSTOP)
    except ProcessLookupError:  # it has ended with the run
        wait_until(served.has_ended, "the run has ended")
        return
    let_pass(_PAUSE_S)
    size = log.stat().st_size
    slow.send_to_group(signal.SIGCONT)
    wait_until(lambda: served.has_ended() or log.stat().st_size > size, "the run goes on")
