"""What can go wrong between participants, in one tree."""

from __future__ import annotations


class BusError(Exception):
    """Base of all errors of the bus."""


class StalledError(BusError):
    """A barrier was not met within the stall limit; the text names what is missing."""


class StoppedError(BusError):
    """The process was asked to end while it waited."""


class PayloadError(BusError):
    """A payload cannot be sent, or is not a message of its topic."""


class NoAnswerError(BusError):
    """Nobody answers for a run at the endpoints given; the text says which."""
