"""Keeps messages until a barrier is met, in whatever order they arrive."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from zenvoy.bus.agent import Barrier, Decoder, Inbox
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.refusals import DUPLICATE, EARLY, MALFORMED, STALE
from zenvoy.bus.topics import Topic

# A message may be this many cycles ahead of the last one taken; later ones are refused. In a fleet,
# messages are at most 3 cycles ahead: the world runs at most two cycles ahead of the oldest one
# that has not ended, and a delivery may be one more ahead.
WINDOW: Final = 8

Check = Callable[[Topic[Any], int, Any], str | None]
"""Takes a message with its topic and vehicle, and returns why it is refused, or None."""


class Mailbox:
    """Messages by topic, cycle and vehicle.

    Refused messages are counted in `rejected` by reason, and change nothing else. `check` is
    applied last. It is None on a bus that no other program can write to. `decoders` are those of
    streams with one message for all vehicles of a process, which has the number 0.
    """

    def __init__(
        self, check: Check | None = None, decoders: Mapping[Topic[Any], Decoder] | None = None
    ) -> None:
        self._decoders = decoders or {}
        self.rejected: Counter[str] = Counter()
        self._check = check
        self._mail: dict[tuple[Topic[Any], int], dict[int, tuple[Any, bytes]]] = {}
        self._taken: dict[Topic[Any], int] = {}
        self._before = -1  # the cycle before the one that is awaited

    def put(self, topic: Topic[Any], vehicle: int, payload: bytes) -> str | None:
        """Decode and keep a message; return the reason if it is refused."""
        try:
            message = self._decoders.get(topic, topic.decode)(payload)
        except PayloadError:
            return self._refuse(MALFORMED)
        cycle, taken = message.cycle, max(self._taken.get(topic, -1), self._before)
        if not taken < cycle <= taken + WINDOW:
            return self._refuse(STALE if cycle <= taken else EARLY)
        slot = self._mail.get((topic, cycle))
        if slot is not None and vehicle in slot:
            return self._refuse(DUPLICATE)
        if self._check is not None and (fault := self._check(topic, vehicle, message)) is not None:
            return self._refuse(fault)
        if slot is None:
            slot = self._mail[topic, cycle] = {}
        slot[vehicle] = (message, payload)
        return None

    def put_together(
        self, topic: Topic[Any], message: Any, parcels: Sequence[tuple[int, bytes]]
    ) -> bool:
        """Keep one message for several vehicles, with the payload of each.

        It has passed all checks but those of `put` itself. Keep nothing and return False if one of
        these would refuse any payload.
        """
        cycle, taken = message.cycle, max(self._taken.get(topic, -1), self._before)
        slot = self._mail.get((topic, cycle), {})
        there = any(vehicle in slot for vehicle, _ in parcels)
        if there or not taken < cycle <= taken + WINDOW:
            return False
        slot.update({vehicle: (message, payload) for vehicle, payload in parcels})
        self._mail[topic, cycle] = slot
        return True

    def expect(self, barrier: Barrier | None) -> None:
        """Note the next barrier: its cycle may be far ahead of the last one taken."""
        if barrier is not None and barrier.needs:
            self._before = barrier.cycle - 1

    def _refuse(self, reason: str) -> str:
        self.rejected[reason] += 1
        return reason

    def has(self, topic: Topic[Any], cycle: int, count: int) -> bool:
        """Return whether messages of `count` vehicles have arrived for that topic and cycle."""
        return len(self._mail.get((topic, cycle), ())) >= count

    def holds(self, topic: Topic[Any], cycle: int, vehicle: int) -> bool:
        """Return whether the message of a vehicle for that topic and cycle has arrived."""
        return vehicle in self._mail.get((topic, cycle), ())

    def met(self, barrier: Barrier) -> bool:
        """Return whether all messages that the barrier needs have arrived."""
        for topic, ids in barrier.needs:  # a plain loop, because this runs after every message
            if len(self._mail.get((topic, barrier.cycle), ())) < len(ids):
                return False
        return True

    def missing(self, barrier: Barrier) -> list[tuple[Topic[Any], int]]:
        """Return what the barrier still waits for, as topics and vehicles."""
        return [
            (topic, vehicle)
            for topic, ids in barrier.needs
            for vehicle in ids
            if vehicle not in self._mail.get((topic, barrier.cycle), ())
        ]

    def describe_missing(self, barrier: Barrier) -> str:
        """Return what the barrier still waits for, in words; name at most five messages."""
        missing = self.missing(barrier)
        shown = [
            topic.name if vehicle == 0 else f"{topic.name} of vehicle {vehicle}"
            for topic, vehicle in missing[:5]
        ]
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        return f"{', '.join(shown)}{more} (cycle {barrier.cycle})"

    def take(self, barrier: Barrier) -> Inbox:
        """Remove and return the messages of a met barrier, in the barrier's order of vehicles."""
        mail: dict[Topic[Any], list[tuple[Any, bytes]]] = {}
        for topic, ids in barrier.needs:
            slot = self._mail.pop((topic, barrier.cycle), {})  # nobody may be needed
            self._taken[topic] = barrier.cycle
            mail[topic] = [slot[vehicle] for vehicle in ids]
        return Inbox(mail)
