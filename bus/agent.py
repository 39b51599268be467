"""Participants: plain objects that say which messages they wait for, and step without a clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar, runtime_checkable

from google.protobuf.message import Message

from zenvoy.bus.bundles import Parcel
from zenvoy.bus.latecomers import Late
from zenvoy.bus.topics import Topic

M = TypeVar("M", bound=Message)


class Envelope(NamedTuple):
    """A message in transit: its stream, the vehicle to which that belongs (0: none), its bytes.

    `time_ns` is its time in the log, if it is logged. `bundled` says that it is one message for all
    vehicles of the process of `vehicle`.
    """

    topic: Topic[Any]
    vehicle: int
    payload: bytes
    time_ns: int = 0
    bundled: bool = False


class Barrier(NamedTuple):
    """The messages that an agent needs for its next step, and the time of that step (ns).

    joins: vehicles whose new processes must be ready before, because the step writes to them.
    """

    now_ns: int
    cycle: int
    needs: tuple[tuple[Topic[Any], Sequence[int]], ...] = ()
    joins: Sequence[int] = ()


class Inbox:
    """The messages that a barrier asked for, by topic, in order of vehicle.

    late: the machine whose messages came last, where the bus measures that.
    """

    __slots__ = ("_mail", "late")

    def __init__(self, mail: dict[Topic[Any], list[tuple[Any, bytes]]]) -> None:
        self._mail = mail
        self.late: Late | None = None

    def all(self, topic: Topic[M]) -> list[M]:
        """Return the messages of `topic`, in order of vehicle."""
        return [message for message, _ in self._mail[topic]]

    def one(self, topic: Topic[M]) -> M:
        """Return the only message of `topic`."""
        ((decoded, _),) = self._mail[topic]
        message: M = decoded
        return message

    def together(self, topic: Topic[Any]) -> Any:
        """Return the only message of `topic`, as the decoder of its agent made it."""
        ((decoded, _),) = self._mail[topic]
        return decoded

    def each(self) -> list[Inbox]:
        """Return an inbox for each vehicle, in order, with its own message of each topic."""
        shares = zip(*self._mail.values(), strict=True)
        return [
            Inbox({t: [one] for t, one in zip(self._mail, share, strict=True)}) for share in shares
        ]

    def with_payloads(self, topic: Topic[M]) -> list[tuple[Any, bytes]]:
        """Return the messages of `topic` and their bytes as received, in order of vehicle.

        Messages that its agent decodes together are one object, which comes for each of them.
        """
        return self._mail[topic]


Decoder = Callable[[bytes], Any]
"""Decodes one message for all vehicles of a process; raises PayloadError."""

JointDecoder = Callable[[Sequence[Parcel]], Any]
"""Decodes messages of several vehicles into one object, or returns None: decode each by itself.

The object has the `cycle` and the `time_ns` of all these messages, and has passed all checks.
"""

Log = Callable[[Topic[Any], int, bytes], None]
"""Takes a message to be logged: its topic, its simulation time (ns), its bytes."""


class Participant(Protocol):
    """A participant of a run, and which streams belong to it."""

    @property
    def name(self) -> str:
        """The name of its process: `world`, `channel`, `vehicle-07`."""

    @property
    def role(self) -> str:
        """`world`, `channel` or `vehicle`; decides which topics it reads."""

    @property
    def vehicles(self) -> tuple[int, ...]:
        """The numbers of its vehicles; empty for world and channel."""

    def fault_in(self, topic: Topic[Any], vehicle: int, message: Any) -> str | None:
        """Return in a word why a message to it is refused, or None; change nothing."""


@runtime_checkable
class TakesBundles(Protocol):
    """A participant that takes one message for all its vehicles, of some streams."""

    decoders: Mapping[Topic[Any], Decoder]


def decoders_of(participant: Participant) -> Mapping[Topic[Any], Decoder]:
    """Return the streams of which a participant takes bundles, with their decoders."""
    return participant.decoders if isinstance(participant, TakesBundles) else {}


@runtime_checkable
class DecodesJointly(Protocol):
    """A participant that decodes the messages of a shared process together, of some streams."""

    joint_decoders: Mapping[Topic[Any], JointDecoder]


def joint_decoders_of(participant: Participant) -> Mapping[Topic[Any], JointDecoder]:
    """Return the streams whose messages a participant decodes together, with their decoders."""
    return participant.joint_decoders if isinstance(participant, DecodesJointly) else {}


def decoded_jointly(decoder: JointDecoder | None, parcels: Sequence[Parcel]) -> Any:
    """Return the messages of a shared process as one object; None to decode them one by one."""
    if decoder is None or len(parcels) < 2:
        return None
    each_once = len({vehicle for vehicle, _ in parcels}) == len(parcels)
    return decoder(parcels) if each_once else None


class Agent(Participant, Protocol):
    """A participant. It never reads a clock, a socket or a global random state."""

    @property
    def barrier(self) -> Barrier | None:
        """The messages that it waits for; None when it is done."""

    def step(self, now_ns: int, inbox: Inbox) -> list[Envelope]:
        """React to the messages of its barrier, and return what it sends, in order."""
