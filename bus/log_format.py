"""What the writer of a log and its readers agree on, beyond MCAP and messages.proto.

Topics stand in `topics`, metadata records in `log_metadata`.
"""

from __future__ import annotations

import hashlib
from typing import Final

from zenvoy.bus.topics import CLOCK, REALTIME, TOPICS

# Log times are this plus simulation time: 2000-01-01T00:00:00Z. Readers take zero for "unknown".
EPOCH_NS: Final = 946_684_800 * 1_000_000_000

SCENARIO: Final = "scenario.yaml"
"""Attachment: the scenario as its file has it."""
EFFECTIVE: Final = "effective.json"
"""Attachment: the scenario with all its values, defaults included."""

WALL_TIME: Final = frozenset({CLOCK.log_name, REALTIME.log_name})
"""Topics with wall times: the fingerprint leaves them out, since they differ in every run."""

CHUNK_BYTES: Final = 1 << 20
"""A chunk is closed by the message that takes it past this size."""

_ROUND: Final = 1 << 64  # instants of a damaged log may lie before the epoch
_NAMES: Final = {
    topic.logged_as: topic.name.encode() + b"\0"
    for topic in TOPICS
    if topic.logged_as is not None and topic.logged_as not in WALL_TIME
}


class Fingerprint:
    """SHA-256 over the messages of a run in the order of the log, those of wall time left out."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()

    def add(self, topic: str, time_ns: int, payload: bytes | memoryview) -> None:
        """Take in a message of `topic`, by its name in the log, at an instant of simulation time.

        Topics that are none of Zenvoy's are left out.
        """
        name = _NAMES.get(topic)
        if name is None:
            return
        head = (time_ns % _ROUND).to_bytes(8, "little") + len(payload).to_bytes(8, "little")
        self._digest.update(name + head)
        self._digest.update(payload)

    def hexdigest(self) -> str:
        """Fingerprint of what was added so far."""
        return self._digest.hexdigest()


def chunk_limit(vehicles: int) -> int:
    """Bytes that a chunk of a log of `vehicles` may unpack to; a log with more is damaged.

    A chunk is at most CHUNK_BYTES and one message, and the largest message has a row per frame and
    receiver: some 60 bytes for each pair of vehicles, twice that with second copies.
    """
    return min((64 << 20) + 160 * vehicles * vehicles, 1 << 30)
