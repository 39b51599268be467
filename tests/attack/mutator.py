"""Mutants of real messages: cut, flipped, replayed, of another cycle, on another key, and more."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

from google.protobuf.message import DecodeError

from tests.attack.messages import READ, Mutant, Seen
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.mailbox import WINDOW
from zenvoy.bus.topics import RECEIVE

MARK: Final = 2.8125
"""m/s², in what is made up; no controller decides exactly that."""


class Mutator:
    """Makes mutants of the messages that it sees, for a fleet of `size`."""

    def __init__(self, run: str, size: int, seed: int) -> None:
        self._run, self._size = run, size
        self._random = random.Random(seed)
        self._seen: deque[Seen] = deque(maxlen=4_000)
        self._newest = 0
        self._makers: tuple[Callable[[Seen], Mutant], ...] = (
            self._rubbish,
            self._cut,
            self._flipped,
            self._replayed,
            self._of_another_cycle,
            self._of_another_time,
            self._of_another_vehicle,
            self._on_a_foreign_key,
            self._on_another_stream,
            self._in_parts,
            self._deleted,
        )

    def see(self, seen: Seen) -> None:
        """Learn a real message."""
        self._seen.append(seen)
        self._newest = max(self._newest, seen.cycle)

    def mutants(self, count: int) -> Iterator[Mutant]:
        """Yield `count` mutants of all kinds in turn."""
        for number in range(count if self._seen else 0):
            maker = self._makers[number % len(self._makers)]
            yield maker(self._random.choice(self._seen))

    def _key(self, seen: Seen) -> str:
        return seen.topic.key(self._run, seen.vehicle)

    def _old(self, seen: Seen) -> Seen:
        """Return a message whose cycle is over for every reader: `seen`, or the oldest."""
        return seen if seen.cycle < self._newest - WINDOW else self._seen[0]

    def _rubbish(self, seen: Seen) -> Mutant:
        return Mutant(self._key(seen), self._random.randbytes(self._random.randrange(1, 200)))

    def _cut(self, seen: Seen) -> Mutant:
        seen = self._old(seen)
        length = self._random.randrange(1, max(2, len(seen.payload)))
        return Mutant(self._key(seen), seen.payload[:length])

    def _flipped(self, seen: Seen) -> Mutant:
        seen = self._old(seen)
        while True:
            payload = bytearray(seen.payload)
            for _ in range(self._random.randrange(1, 8)):
                payload[self._random.randrange(len(payload))] ^= 1 << self._random.randrange(8)
            if not _arrives_at_another_time(seen, bytes(payload)):
                return Mutant(self._key(seen), bytes(payload))

    def _replayed(self, seen: Seen) -> Mutant:
        """Replay a message, even one of the present cycle."""
        return Mutant(self._key(seen), seen.payload)

    def _of_another_cycle(self, seen: Seen) -> Mutant:
        message = self._marked(seen)
        steps = [*range(-20, 0), *range(1, 20), 100, 10**9]
        message.cycle = min(max(0, seen.cycle + self._random.choice(steps)), 2**32 - 1)
        if message.cycle == seen.cycle:
            message.cycle = 2**32 - 1
        return Mutant(self._key(seen), message.SerializeToString())

    def _of_another_time(self, seen: Seen) -> Mutant:
        message = self._marked(seen)
        steps = (-(10**8), 1, 10**6, 10**8, 10**15)
        times = [*(message.time_ns + step for step in steps), -(2**63), 2**63 - 1]
        message.time_ns = self._random.choice(times)
        message.cycle = self._newest + self._random.randrange(4)
        if message.time_ns // 10**8 == message.cycle:
            message.time_ns = -1
        return Mutant(self._key(seen), message.SerializeToString())

    def _of_another_vehicle(self, seen: Seen) -> Mutant:
        """Send a vehicle's message, with its cycle and time, as that of another vehicle."""
        if not seen.topic.per_vehicle:
            return self._on_a_foreign_key(seen)
        other = seen.vehicle % self._size + 1
        return Mutant(seen.topic.key(self._run, other), seen.payload)

    def _on_a_foreign_key(self, seen: Seen) -> Mutant:
        own = self._key(seen)
        strangers = [f"vehicle/{who}/{what}" for who in (0, 99, "x", "٣") for what in _NAMES]
        keys = ["**", "*/*/**", *(f"zenvoy/{self._run}/{end}" for end in (*strangers, "**"))]
        keys += [own.rpartition("/")[0] + "/*", f"zenvoy/*/{own.split('/', 2)[2]}"]
        return Mutant(self._random.choice(keys), seen.payload)

    def _on_another_stream(self, seen: Seen) -> Mutant:
        other = self._random.choice([topic for topic in READ if topic is not seen.topic])
        return Mutant(other.key(self._run, seen.vehicle or 1), seen.payload)

    def _in_parts(self, seen: Seen) -> Mutant:
        attachment = self._random.randbytes(self._random.choice((3, 12, 12, 12)))
        if self._random.random() < 0.5:  # one part without all the others
            attachment = b"\0\0\0\0" + b"\2\0\0\0" + attachment[-3:] + b"\0"
        return Mutant(self._key(seen), seen.payload, attachment)

    def _deleted(self, seen: Seen) -> Mutant:
        return Mutant(self._key(seen), None)

    def _marked(self, seen: Seen) -> Any:
        message = seen.topic.decode(seen.payload)
        if hasattr(message, "acceleration"):
            message.acceleration = self._random.choice((MARK, float("nan"), 1e308))
        return message


_NAMES: Final = ("sense", "beacon", "receive", "command")


def _arrives_at_another_time(seen: Seen, payload: bytes) -> bool:
    """Return whether flips change both times of a receive alike, which makes a valid frame."""
    if seen.topic is not RECEIVE:
        return False
    try:
        message = pb.Receive.FromString(payload)
    except DecodeError:
        return False
    real = pb.Receive.FromString(seen.payload)
    last_ns = max(message.arrived_ns, default=message.time_ns)
    return message.time_ns != real.time_ns and last_ns == message.time_ns
