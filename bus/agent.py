"""What every participant is: a plain object that says what it waits for, and a pure step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from google.protobuf.message import Message

from zenvoy.bus.topics import Topic

M = TypeVar("M", bound=Message)


class Envelope(NamedTuple):
    """A message on its way: its stream, the vehicle whose stream it is (0: none), its bytes.

    `time_ns` is the instant it is logged under, where it is logged.
    """

    topic: Topic[Any]
    vehicle: int
    payload: bytes
    time_ns: int = 0


class Barrier(NamedTuple):
    """What an agent needs before its next step, and the instant of that step (ns)."""

    now_ns: int
    cycle: int
    needs: tuple[tuple[Topic[Any], Sequence[int]], ...] = ()


class Inbox:
    """The messages a barrier asked for: for each topic, in order of vehicle."""

    __slots__ = ("_mail",)

    def __init__(self, mail: dict[Topic[Any], list[tuple[Any, bytes]]]) -> None:
        self._mail = mail

    def all(self, topic: Topic[M]) -> list[M]:
        """Messages of `topic`, in order of vehicle."""
        return [message for message, _ in self._mail[topic]]

    def one(self, topic: Topic[M]) -> M:
        """The one message of `topic`."""
        ((decoded, _),) = self._mail[topic]
        message: M = decoded
        return message

    def each(self) -> list[Inbox]:
        """An inbox for each vehicle, in order: its own message of each topic."""
        shares = zip(*self._mail.values(), strict=True)
        return [
            Inbox({t: [one] for t, one in zip(self._mail, share, strict=True)}) for share in shares
        ]

    def with_payloads(self, topic: Topic[M]) -> list[tuple[M, bytes]]:
        """Messages of `topic`, each with its bytes on the wire, in order of vehicle."""
        return self._mail[topic]


Log = Callable[[Topic[Any], int, bytes], None]
"""Takes what is logged: its topic, its instant of simulation time (ns), its bytes."""


class Participant(Protocol):
    """Who takes part in a run, and which streams are its own."""

    @property
    def name(self) -> str:
        """Name of its process: `world`, `channel`, `vehicle-07`."""

    @property
    def role(self) -> str:
        """`world`, `channel` or `vehicle`: which topics it reads."""

    @property
    def vehicles(self) -> tuple[int, ...]:
        """Numbers of the vehicles that it is; none for world and channel."""

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Why a message to it makes no sense, in a word; None where it does. It changes nothing."""


class Agent(Participant, Protocol):
    """A participant. It never reads a clock, a socket or a global random state."""

    @property
    def barrier(self) -> Barrier | None:
        """What it waits for; None when it is done."""

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """React to the messages of its barrier; returns what it sends, in order."""
