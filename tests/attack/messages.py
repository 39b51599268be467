"""The messages that the attacker reads, real ones and those that it makes up."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from zenvoy.bus.topics import BEACON, COMMAND, LINKS, POSITIONS, RECEIVE, SENSE, Topic

READ: Final = (SENSE, BEACON, RECEIVE, COMMAND, POSITIONS, LINKS)


def streams(run: str, size: int) -> dict[str, tuple[Topic[Any], int]]:
    """Return topic and vehicle (0: none) of every stream that has a reader, by key."""
    return {
        topic.key(run, vehicle): (topic, vehicle)
        for topic in READ
        for vehicle in (range(1, size + 1) if topic.per_vehicle else (0,))
    }


class Seen(NamedTuple):
    """A real message."""

    topic: Topic[Any]
    vehicle: int
    payload: bytes
    cycle: int


class Mutant(NamedTuple):
    """A message of the attacker. A payload of None is a deletion."""

    key: str
    payload: bytes | None
    attachment: bytes | None = None
