"""Requests to end are held during a fork, whichever thread takes the signal."""

from __future__ import annotations

import os
import signal
import threading
from contextlib import suppress

import pytest

from tests.fork_strike import strike_at_fork
from zenvoy.fleet.requests import (
    REQUESTS_TO_END,
    interruptible,
    requests_held,
    requests_to_end_handled_by,
)


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


def _turn_into_an_error(number: signal.Signals) -> None:
    """Do what a library does whose callback is interrupted."""
    try:
        signal.raise_signal(number)
    except KeyboardInterrupt as interrupt:
        raise ValueError("error in a callback") from interrupt


@pytest.mark.parametrize("number", REQUESTS_TO_END)
def test_a_request_that_a_library_turns_into_its_error_is_one(number: signal.Signals) -> None:
    with pytest.raises(KeyboardInterrupt), interruptible():
        _turn_into_an_error(number)
    with pytest.raises(ValueError, match="of its own"), interruptible():
        raise ValueError("of its own")


@pytest.mark.parametrize("number", REQUESTS_TO_END)
def test_a_request_that_a_library_swallows_reaches_the_next_handler(number: signal.Signals) -> None:
    noted: list[int] = []
    with interruptible():
        with suppress(KeyboardInterrupt):  # as in a callback of a library
            signal.raise_signal(number)
        with requests_to_end_handled_by(lambda got, _: noted.append(got)):
            assert noted == [number]
        with requests_to_end_handled_by(lambda got, _: noted.append(got)):
            assert noted == [number]
    with interruptible(), requests_to_end_handled_by(lambda got, _: noted.append(got)):
        assert noted == [number]


def _end_with_handlers(noted: list[int]) -> None:
    """Handle requests while one ends this function."""
    try:
        signal.raise_signal(signal.SIGINT)
    finally:
        with requests_to_end_handled_by(lambda got, _: noted.append(got)):
            pass


def test_a_request_that_is_being_answered_is_not_given_again() -> None:
    noted: list[int] = []
    with pytest.raises(KeyboardInterrupt), interruptible():
        _end_with_handlers(noted)
    assert noted == []
