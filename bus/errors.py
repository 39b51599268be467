"""The errors of communication between participants, in one tree."""

from __future__ import annotations

from collections.abc import Sequence


class BusError(Exception):
    """The base of all errors of the bus."""


class StalledError(BusError):
    """A barrier was not met within the stall limit; the text names what is missing.

    `culprits` are the processes that should have sent it, if they are known.
    """

    def __init__(self, text: str, culprits: Sequence[str] = ()) -> None:
        super().__init__(text)
        self.culprits = tuple(culprits)


class RouterError(StalledError):
    """A Zenoh router is not there, or does not let this process in; the text names it."""


class StoppedError(BusError):
    """The process was asked to end while it waited."""


class VehicleLostError(BusError):
    """A scenario's fault has killed the process of a vehicle, and the run is to end then."""

    def __init__(self, name: str, at_s: float) -> None:
        super().__init__(f"killed by a fault of the scenario at {at_s:g} s")
        self.name = name


class PayloadError(BusError):
    """A payload cannot be sent, or is not a message of its topic."""


class NoAnswerError(BusError):
    """No run answers at the given endpoints; the text names them."""


class SeveralRunsError(BusError):
    """Several runs answer at the given endpoints; the text lists them."""
