"""Looks up the messages of any cycle in a log, without reading what lies before it."""

from __future__ import annotations

import struct
from bisect import bisect_left
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from google.protobuf.message import DecodeError

from zenvoy.analysis.log.cycles import cycle_of
from zenvoy.analysis.log.records import LogError
from zenvoy.analysis.view.growing_log import GrowingLog, Place
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import CLOCK, ESTIMATE, EVENTS, FLEET_COMMAND, FRAMES, RADAR, TRUTH

SHOWN: Final = {topic.log_name for topic in (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND, FRAMES, CLOCK)}
_KEPT_BYTES: Final = 64 << 20  # of unpacked chunks

Payloads = dict[str, list[memoryview]]
"""The messages of one cycle, by topic."""


@dataclass(slots=True)
class _Unpacked:
    """The messages of a chunk by cycle, its events, and its size in bytes."""

    size: int = 0
    cycles: dict[int, Payloads] = field(default_factory=dict)
    events: list[pb.Event] = field(default_factory=list)


class Messages:
    """The messages of a log by cycle. It keeps the chunks that were used last.

    A message of cycle k is logged at most `behind_ns` after the cycle begins.
    """

    def __init__(self, log: GrowingLog, epoch_ns: int, period_ns: int, behind_ns: int) -> None:
        self._log = log
        self._epoch_ns = epoch_ns
        self._period_ns = period_ns
        self._behind_ns = behind_ns
        self._kept: OrderedDict[int, _Unpacked] = OrderedDict()
        self._kept_bytes = 0
        self._latest: list[int] = []  # last_ns of chunks, or of an earlier one if that is later

    def of(self, first: int, last: int) -> dict[int, Payloads]:
        """Return the messages of cycles `first` to `last`; raises LogError for a damaged chunk."""
        found: dict[int, Payloads] = {}
        for place in self._places(first, last):
            for cycle, payloads in self.chunk(place).cycles.items():
                if first <= cycle <= last:
                    into = found.setdefault(cycle, {})
                    for topic, some in payloads.items():
                        into.setdefault(topic, []).extend(some)
        return found

    def chunk(self, place: Place) -> _Unpacked:
        """Return what a chunk holds; raises LogError where it is damaged."""
        if place.at in self._kept:
            self._kept.move_to_end(place.at)
            return self._kept[place.at]
        try:
            read = self._read(place)
        except (DecodeError, ValueError, struct.error) as error:
            raise LogError(f"{self._log.path}: damaged at byte {place.at}: {error}") from error
        self._kept[place.at] = read
        self._kept_bytes += read.size
        while self._kept_bytes > _KEPT_BYTES and len(self._kept) > 1:
            self._kept_bytes -= self._kept.popitem(last=False)[1].size
        return read

    def _places(self, first: int, last: int) -> Iterator[Place]:
        """Yield the chunks that may have messages of these cycles."""
        chunks = self._log.chunks
        for place in chunks[len(self._latest) :]:
            self._latest.append(max(place.last_ns, self._latest[-1] if self._latest else 0))
        from_ns = self._epoch_ns + first * self._period_ns
        until_ns = self._epoch_ns + last * self._period_ns + self._behind_ns
        for place in chunks[bisect_left(self._latest, from_ns) :]:
            if place.first_ns > until_ns + self._behind_ns:
                return
            if place.first_ns <= until_ns:
                yield place

    def _read(self, place: Place) -> _Unpacked:
        read = _Unpacked()
        for topic, _, payload in self._log.messages(place):
            read.size += len(payload)
            if topic in SHOWN:
                of_cycle = read.cycles.setdefault(cycle_of(payload), {})
                of_cycle.setdefault(topic, []).append(payload)
            elif topic == EVENTS.log_name:
                read.events.append(pb.Event.FromString(bytes(payload)))
        return read
