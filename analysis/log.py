"""A run's log as numpy arrays, read as a stream."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import ESTIMATE, EVENTS, FLEET_COMMAND, FRAMES, LOGGED, RADAR, TRUTH
from zenvoy.scenarios import Scenario

Table = dict[str, NDArray[Any]]

_FLEET: Final = (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND)


class LogError(Exception):
    """A file that is no log of a run, or of which nothing can be read."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What stands in the log beside its messages."""

    run: dict[str, str]
    result: dict[str, str]
    scenario: Scenario
    counts: dict[str, int]


def read_facts(path: Path) -> Facts:
    """Metadata, scenario and message counts by topic; raises LogError."""
    try:
        with path.open("rb") as file:
            _check_ends(path, file)
            reader = make_reader(file)
            summary = reader.get_summary()
            records = {record.name: record.metadata for record in reader.iter_metadata()}
            texts = {item.name: item.data.decode() for item in reader.iter_attachments()}
    except OSError as error:
        raise LogError(f"{path}: {error.strerror}") from error
    except (McapError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: damaged: {error or type(error).__name__}") from error
    if summary is None or summary.statistics is None or "zenvoy.run" not in records:
        raise LogError(f"{path}: an MCAP file, but not the log of a run")
    scenario = Scenario.model_validate_json(texts["effective.json"])
    counts = {topic.logged_as or "": 0 for topic in LOGGED}
    for channel, count in summary.statistics.channel_message_counts.items():
        counts[summary.channels[channel].topic] = count
    return Facts(
        run=records["zenvoy.run"],
        result=records.get("zenvoy.result", {}),
        scenario=scenario,
        counts=counts,
    )


def read_fleet(path: Path) -> dict[str, Table]:
    """The fleet topics by name: each a table of arrays, (cycles, vehicles) or (cycles,)."""
    rows: dict[str, list[Table]] = {topic.logged_as or "": [] for topic in _FLEET}
    codecs = {topic.logged_as: PackedCodec(topic.message.DESCRIPTOR) for topic in _FLEET}
    for name, payload in messages(path, list(rows)):
        rows[name].append(codecs[name].decode(payload))
    return {name: _stack(of_topic) for name, of_topic in rows.items()}


def read_frames(path: Path) -> Iterator[Table]:
    """`/v2v/frames`, cycle by cycle: columns with a row per frame and receiver."""
    codec = PackedCodec(FRAMES.message.DESCRIPTOR)
    for _, payload in messages(path, ["/v2v/frames"]):
        yield codec.decode(payload)


def read_events(path: Path) -> list[Any]:
    """`/events` as messages, in order of the log."""
    return [EVENTS.decode(payload) for _, payload in messages(path, ["/events"])]


def messages(path: Path, topics: Sequence[str]) -> Iterator[tuple[str, bytes]]:
    """Topic and payload of each message, in the order in which they were written."""
    with path.open("rb") as file:
        found = make_reader(file).iter_messages(topics=list(topics), log_time_order=False)
        for _, channel, message in found:
            yield channel.topic, message.data


def _check_ends(path: Path, file: BinaryIO) -> None:
    """See whether the file begins and ends like an MCAP file; raises LogError."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise LogError(f"{path}: not an MCAP file")
    file.seek(max(0, size - len(MCAP0_MAGIC)))
    if size < 2 * len(MCAP0_MAGIC) or file.read() != MCAP0_MAGIC:
        raise LogError(f"{path}: cut off before its end; the run was killed, or the copy failed")
    file.seek(0)


def as_json(values: object) -> str:
    """JSON for files that people read too."""
    return json.dumps(values, indent=2, ensure_ascii=False) + "\n"


def _stack(rows: list[Table]) -> Table:
    if not rows:
        return {}
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}
