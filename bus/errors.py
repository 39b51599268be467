"""What can go wrong between participants, in one tree."""

from __future__ import annotations

from collections.abc import Sequence


class BusError(Exception):
    """Base of all errors of the bus."""


class StalledError(BusError):
    """A barrier was not met within the stall limit; the text names what is missing.

    `culprits` are the processes that it should have come from, where these are known.
    """

    def __init__(self, text: str, culprits: Sequence[str] = ()) -> None:
        super().__init__(text)
        self.culprits = tuple(culprits)


class StoppedError(BusError):
    """The process was asked to end while it waited."""


class PayloadError(BusError):
    """A payload cannot be sent, or is not a message of its topic."""


class NoAnswerError(BusError):
    """Nobody answers for a run at the endpoints given; the text says which."""
