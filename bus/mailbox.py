"""Keeps messages until a barrier is met, whatever order they come in."""

from __future__ import annotations

from collections import Counter
from typing import Any

from zenvoy.bus.agent import Barrier, Inbox
from zenvoy.bus.errors import PayloadError
from zenvoy.bus.topics import Topic


class Mailbox:
    """Messages by topic, cycle and vehicle.

    What does not fit is counted in `rejected` by reason (`malformed`, `stale`, `duplicate`) and
    changes nothing.
    """

    def __init__(self) -> None:
        self.rejected: Counter[str] = Counter()
        self._mail: dict[tuple[Topic[Any], int], dict[int, tuple[Any, bytes]]] = {}
        self._taken: dict[Topic[Any], int] = {}

    def put(self, topic: Topic[Any], vehicle: int, payload: bytes) -> None:
        """Decode and keep one message."""
        try:
            message = topic.decode(payload)
        except PayloadError:
            self.rejected["malformed"] += 1
            return
        cycle = message.cycle
        if cycle <= self._taken.get(topic, -1):
            self.rejected["stale"] += 1
            return
        slot = self._mail.setdefault((topic, cycle), {})
        if vehicle in slot:
            self.rejected["duplicate"] += 1
            return
        slot[vehicle] = (message, payload)

    def has(self, topic: Topic[Any], cycle: int, count: int) -> bool:
        """Whether `count` vehicles' messages of that topic and cycle are here."""
        return len(self._mail.get((topic, cycle), ())) >= count

    def met(self, barrier: Barrier) -> bool:
        """Whether all that the barrier asks for is here."""
        for topic, ids in barrier.needs:  # a plain loop: it is asked after every message
            if len(self._mail.get((topic, barrier.cycle), ())) < len(ids):
                return False
        return True

    def missing(self, barrier: Barrier) -> list[tuple[Topic[Any], int]]:
        """What the barrier still waits for, as topic and vehicle."""
        return [
            (topic, vehicle)
            for topic, ids in barrier.needs
            for vehicle in ids
            if vehicle not in self._mail.get((topic, barrier.cycle), ())
        ]

    def describe_missing(self, barrier: Barrier) -> str:
        """What the barrier still waits for, in words, five at most."""
        missing = self.missing(barrier)
        shown = [
            topic.name if vehicle == 0 else f"{topic.name} of vehicle {vehicle}"
            for topic, vehicle in missing[:5]
        ]
        more = f" and {len(missing) - 5} more" if len(missing) > 5 else ""
        return f"{', '.join(shown)}{more} (cycle {barrier.cycle})"

    def take(self, barrier: Barrier) -> Inbox:
        """Messages of a met barrier, in the barrier's order of vehicles."""
        mail: dict[Topic[Any], list[tuple[Any, bytes]]] = {}
        for topic, ids in barrier.needs:
            slot = self._mail.pop((topic, barrier.cycle))
            self._taken[topic] = barrier.cycle
            mail[topic] = [slot[vehicle] for vehicle in ids]
        return Inbox(mail)
