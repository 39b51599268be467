"""The format of a log beyond MCAP and messages.proto, on which its writer and readers agree.

Topics are in `topics`, metadata records in `log_metadata`.
"""

from __future__ import annotations

import hashlib
from typing import Final

from zenvoy.bus.topics import CLOCK, REALTIME, TOPICS

# Times in a log are simulation time plus this epoch, 2000-01-01T00:00:00Z, because readers take 0
# for "unknown".
EPOCH_NS: Final = 946_684_800 * 1_000_000_000

SCENARIO: Final = "scenario.yaml"
"""Attachment with the scenario as written in its file."""
EFFECTIVE: Final = "effective.json"
"""Attachment with the scenario and all its values, including defaults."""

WALL_TIME: Final = frozenset({CLOCK.log_name, REALTIME.log_name})
"""Topics with wall times, which the fingerprint leaves out because they differ in every run."""

CHUNK_BYTES: Final = 1 << 20
"""The message that takes a chunk past this size closes it."""

_MODULUS: Final = 1 << 64  # times in a damaged log may be before the epoch, and so negative
_NAMES: Final = {
    topic.logged_as: topic.name.encode() + b"\0"
    for topic in TOPICS
    if topic.logged_as is not None and topic.logged_as not in WALL_TIME
}


class Fingerprint:
    """SHA-256 over the messages of a run in the order of the log, without those with wall times."""

    def __init__(self) -> None:
        self._digest = hashlib.sha256()

    def add(self, topic: str, time_ns: int, payload: bytes | memoryview) -> None:
        """Add a message; topic: its name in the log; time_ns: its simulation time.

        Topics that Zenvoy does not declare are ignored.
        """
        name = _NAMES.get(topic)
        if name is None:
            return
        head = (time_ns % _MODULUS).to_bytes(8, "little") + len(payload).to_bytes(8, "little")
        self._digest.update(name + head)
        self._digest.update(payload)

    def hexdigest(self) -> str:
        """Return the fingerprint of the messages added so far."""
        return self._digest.hexdigest()


def chunk_limit(vehicles: int) -> int:
    """Return how many bytes a chunk of a log of `vehicles` may unpack to; more means damage.

    A chunk has at most CHUNK_BYTES and one more message. The largest message has a row per frame
    and receiver: about 60 bytes for each pair of vehicles, or twice that with second copies.
    """
    return min((64 << 20) + 160 * vehicles * vehicles, 1 << 30)
