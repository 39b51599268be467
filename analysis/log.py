"""A run's log as numpy arrays, read as a stream, up to the cut where it is cut."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from zenvoy.analysis.columns import Table, stack
from zenvoy.analysis.records import LogError, Pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import ESTIMATE, EVENTS, FLEET_COMMAND, FRAMES, LOGGED, RADAR, TRUTH
from zenvoy.scenarios import Scenario

__all__ = ["Facts", "LogError", "Table", "as_json", "read_facts"]

_FLEET: Final = (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND)


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What stands in the log beside its messages.

    `whole` is False where the file is cut; `result` is empty where the cut is before it, and
    `counts` are those of the messages up to the cut.
    """

    run: dict[str, str]
    result: dict[str, str]
    scenario: Scenario
    counts: dict[str, int]
    whole: bool

    @property
    def duration_s(self) -> float:
        """How long the run was to be, s."""
        return self.scenario.cycles * self.scenario.period_ns * 1e-9

    @property
    def cut(self) -> str | None:
        """A sentence that says up to where a cut log could be read; None for a whole one."""
        if self.whole:
            return None
        cycle = max(0, self.counts["/fleet/truth"] - 1)
        read_s = cycle * self.scenario.period_ns * 1e-9
        return f"the log is cut: read up to {read_s:g} s of {self.duration_s:g} s"


def read_facts(path: Path) -> Facts:
    """Metadata, scenario and message counts by topic; raises LogError."""
    with Pass(path) as log:
        for _ in log.messages(()):
            pass
    if log.whole and log.statistics is not None:
        by_channel = log.statistics.channel_message_counts
        return facts_of(path, log, {log.channels[of]: count for of, count in by_channel.items()})
    with Pass(path) as log:
        return facts_of(path, log, Counter(topic for topic, _ in log.messages(None)))


def facts_of(path: Path, log: Pass, counts: dict[str, int]) -> Facts:
    """Facts of the log at `path` after a pass over it; raises LogError."""
    if "zenvoy.run" not in log.metadata and (log.whole or log.chunks or log.metadata):
        raise LogError(f"{path}: an MCAP file, but not the log of a run")
    if "zenvoy.run" not in log.metadata or "effective.json" not in log.attachments:
        raise LogError(f"{path}: cut off before it says what it is the log of")
    try:
        scenario = Scenario.model_validate_json(log.attachments["effective.json"])
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise LogError(f"{path}: effective.json in it: {place}: {first['msg']}") from error
    return Facts(
        run=log.metadata["zenvoy.run"],
        result=log.metadata.get("zenvoy.result", {}),
        scenario=scenario,
        counts={topic.logged_as or "": 0 for topic in LOGGED} | counts,
        whole=log.whole,
    )


def read_fleet(path: Path) -> dict[str, Table]:
    """The fleet topics by name: each a table of arrays, (cycles, vehicles) or (cycles,)."""
    rows: dict[str, list[bytes]] = {topic.logged_as or "": [] for topic in _FLEET}
    for name, payload in messages(path, list(rows)):
        rows[name].append(bytes(payload))
    return {topic.logged_as or "": stack_of(path, topic.logged_as or "", rows) for topic in _FLEET}


def stack_of(path: Path, name: str, payloads: dict[str, list[bytes]]) -> Table:
    """Table of one topic of the log at `path`; raises LogError."""
    descriptor = next(topic.message.DESCRIPTOR for topic in LOGGED if topic.logged_as == name)
    try:
        return stack(PackedCodec(descriptor), payloads[name])
    except ValueError as error:
        raise LogError(f"{path}: {name}: {error}") from error


def read_frames(path: Path) -> Iterator[Table]:
    """`/v2v/frames`, cycle by cycle: columns with a row per frame and receiver."""
    codec = PackedCodec(FRAMES.message.DESCRIPTOR)
    for name, payload in messages(path, ["/v2v/frames"]):
        try:
            yield codec.decode(payload)
        except ValueError as error:
            raise LogError(f"{path}: {name}: {error}") from error


def read_events(path: Path) -> list[pb.Event]:
    """`/events` as messages, in order of the log."""
    return [EVENTS.decode(bytes(payload)) for _, payload in messages(path, ["/events"])]


def messages(path: Path, topics: Sequence[str]) -> Iterator[tuple[str, memoryview]]:
    """Topic and payload of each message, in the order in which they were written."""
    with Pass(path) as log:
        yield from log.messages(topics)


def as_json(values: object) -> str:
    """JSON for files that people read too."""
    return json.dumps(values, indent=2, ensure_ascii=False) + "\n"
