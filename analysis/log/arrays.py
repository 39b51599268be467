"""Reads a run's log into numpy arrays, as a stream. A log that is cut is read up to the cut."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from zenvoy.analysis.log.columns import Table
from zenvoy.analysis.log.cycles import Cycles
from zenvoy.analysis.log.facts import Facts
from zenvoy.analysis.log.reading import read
from zenvoy.analysis.log.records import LogError, Pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import ESTIMATE, EVENTS, FLEET_COMMAND, FRAMES, RADAR, TRUTH

__all__ = ["Facts", "LogError", "Table", "as_json", "read_facts"]

_FLEET: Final = (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND)


def read_facts(path: Path) -> Facts:
    """Return metadata, scenario, message counts by topic, and the checks; raises LogError."""
    return read(path).facts


def read_fleet(path: Path) -> dict[str, Table]:
    """Return the fleet topics by name: each a table of arrays, (cycles, vehicles) or (cycles,)."""
    tables = read(path).tables
    return {topic.log_name: tables[topic.log_name] for topic in _FLEET}


def read_frames(path: Path) -> Iterator[Table]:
    """Yield `/v2v/frames` cycle by cycle: columns with a row per frame and receiver."""
    codec = PackedCodec(FRAMES.message.DESCRIPTOR)
    for name, payload in messages(path, [FRAMES.log_name]):
        try:
            yield codec.decode(payload)
        except ValueError as error:
            raise LogError(f"{path}: {name}: {error}") from error


def read_events(path: Path) -> list[pb.Event]:
    """Return the messages of `/events` in the order of the log."""
    return read(path).events


def messages(path: Path, topics: Sequence[str]) -> Iterator[tuple[str, memoryview]]:
    """Yield topic and payload of each message, in the order in which they were written.

    A topic with one message per cycle is read up to the first cycle that is missing.
    """
    cycles = {topic: Cycles() for topic in topics if topic != EVENTS.log_name}
    with Pass(path) as log:
        for message in log.messages(topics):
            if message.topic not in cycles or cycles[message.topic].take(message.payload):
                yield message.topic, message.payload


def as_json(values: object) -> str:
    """Return `values` as indented JSON, which people can read too."""
    return json.dumps(values, indent=2, ensure_ascii=False) + "\n"
