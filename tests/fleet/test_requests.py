"""Requests to end are held during a fork, whichever thread takes the signal."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from tests.fork_strike import strike_at_fork
from zenvoy.fleet.requests import REQUESTS_TO_END, interruptible, requests_held


def _forked() -> int:
    """Return the exit status of a child that is forked while requests are held."""
    with requests_held():
        child = os.fork()
        if child == 0:
            blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
            os._exit(0 if blocked >= set(REQUESTS_TO_END) else 1)
    return os.waitpid(child, 0)[1]


@pytest.mark.parametrize("number", REQUESTS_TO_END)
def test_a_request_in_a_fork_is_not_lost(number: signal.Signals) -> None:
    """A thread of a library blocks no signals. Here, one waits."""
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    try:
        with pytest.raises(KeyboardInterrupt), interruptible(), strike_at_fork(number):
            _forked()
    finally:
        over.set()
        other.join()
        os.wait()


def test_a_child_has_requests_blocked() -> None:
    assert _forked() == 0
    assert not signal.pthread_sigmask(signal.SIG_BLOCK, ()) & set(REQUESTS_TO_END)
