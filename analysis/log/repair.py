"""Makes a whole log from a cut or damaged one: everything that can be read, with a proper end."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import IO

from google.protobuf.message import DecodeError

from zenvoy.analysis.log.cycles import cycle_of
from zenvoy.analysis.log.facts import Facts
from zenvoy.analysis.log.reading import TABLES, read
from zenvoy.analysis.log.records import LogError, Message, Pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_format import EPOCH_NS, Fingerprint
from zenvoy.bus.log_metadata import (
    REPAIR,
    RESULT,
    RUN,
    ResultMetadata,
    read_epoch_ns,
    sealed,
    unsealed,
)
from zenvoy.bus.log_writer import LogWriter
from zenvoy.bus.topics import CLOCK, FRAMES, REALTIME, TRUTH

_PER_CYCLE = frozenset({*TABLES, FRAMES.log_name, REALTIME.log_name})


class RepairError(Exception):
    """The new file exists already."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Repaired:
    """The result of a repair: the new log, and what is in it."""

    path: Path
    found: tuple[str, ...]
    """The faults of the old log."""
    facts: Facts
    """Facts of the new log."""


def repair(path: Path, out: Path | None, *, salvage: bool = False) -> Repaired | None:
    """Write what can be read of the log at `path` as a whole log; None if it is whole already.

    The new file is `out`, else `<name>-repaired.mcap` beside the log. It must not exist. It has
    all messages up to a cut, and with `salvage` also those after a damaged part. Where no message
    is missing it keeps the result of the run. Otherwise its result says that the log was cut or
    damaged. Raises LogError where nothing can be read, or where only `salvage` can help;
    RepairError; and OSError where the new file cannot be written.
    """
    found = _faults(path, salvage)
    if not found:
        return None
    out = path.with_name(f"{path.stem}-repaired.mcap") if out is None else out
    if out.exists():
        raise RepairError(f"{out}: exists already; name a new file")
    part = out.with_name(f".{out.name}.{os.getpid()}.part")
    try:
        with part.open("xb") as file:
            _copy(path, file, found, salvage)
        part.replace(out)
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    return Repaired(path=out, found=found, facts=read(out).facts)


def _faults(path: Path, salvage: bool) -> tuple[str, ...]:
    """Return the faults of a log; raises LogError where it cannot be repaired without `salvage`."""
    try:
        facts = read(path).facts
    except LogError:
        if not salvage:
            raise
        with Pass(path, salvage=True) as log:
            for _ in log.messages(None):
                pass
        if RUN not in log.metadata:
            raise
        return tuple(log.faults) or ("the log is damaged",)
    if facts.faults and not salvage:
        raise LogError(f"{path}: {facts.faults[0]}; --salvage saves what can be read")
    return (*([facts.cut] if facts.cut else []), *facts.faults)


def _copy(path: Path, file: IO[bytes], found: tuple[str, ...], salvage: bool) -> None:
    writer = LogWriter(file)
    writer.start(profile="", library=f"zenvoy {version('zenvoy')}")
    copy = _Copy(writer)
    with Pass(path, salvage=salvage) as log:
        for message in log.messages(None):
            copy.all_but_messages(log)
            copy.message(log, message)
        copy.all_but_messages(log)
    result = log.metadata.get(RESULT)
    if result is None or result.get("fingerprint") != copy.fingerprint.hexdigest():
        result = copy.result(log.whole)
    writer.flush()
    writer.add_metadata(REPAIR, sealed({"of": path.name, "found": "; ".join(found)}))
    writer.add_metadata(RESULT, sealed(unsealed(result)))
    writer.finish()


class _Copy:
    """Writes what a pass over a log finds, each record once."""

    def __init__(self, writer: LogWriter) -> None:
        self._writer = writer
        self._metadata = {RESULT, REPAIR}  # these are written last
        self._attachments: set[str] = set()
        self._channels: dict[int, int] = {}
        self._schemas: dict[int, int] = {0: 0}
        self._cycles: dict[str, set[int]] = {topic: set() for topic in _PER_CYCLE}
        self._clock = pb.Clock()
        self._epoch_ns = EPOCH_NS
        self.fingerprint = Fingerprint()

    def all_but_messages(self, log: Pass) -> None:
        """Write metadata and attachments that were not written yet."""
        for name, facts in log.metadata.items():
            if name not in self._metadata:
                self._metadata.add(name)
                self._writer.add_metadata(name, sealed(unsealed(facts)))
                if name == RUN:
                    self._epoch_ns = read_epoch_ns(facts)
        for name, attachment in log.attachments.items():
            if name not in self._attachments:
                self._attachments.add(name)
                self._writer.add_attachment(
                    attachment.create_time,
                    attachment.log_time,
                    name,
                    attachment.media_type,
                    attachment.data,
                )

    def message(self, log: Pass, message: Message) -> None:
        """Write a message, unless one with the same topic and cycle was written before."""
        payload = bytes(message.payload)
        cycles = self._cycles.get(message.topic)
        if cycles is not None:
            cycle = cycle_of(payload)
            if cycle in cycles:
                return
            cycles.add(cycle)
        if message.topic == CLOCK.log_name:
            with suppress(DecodeError):
                self._clock = pb.Clock.FromString(payload)
        self.fingerprint.add(message.topic, message.log_time_ns - self._epoch_ns, payload)
        self._writer.add_message(
            self._channel(log, message.channel),
            message.log_time_ns,
            payload,
            message.publish_time_ns,
            message.sequence,
        )

    def result(self, whole: bool) -> dict[str, str]:
        """Return a result for what was written, for a log that lost messages or its own result."""
        return ResultMetadata(
            end="damaged" if whole else "cut",
            fingerprint=self.fingerprint.hexdigest(),
            cycles=max(self._cycles[TRUTH.log_name], default=0),
            clock=self._clock,
        ).written()

    def _channel(self, log: Pass, number: int) -> int:
        if number not in self._channels:
            channel = log.channels[number]
            schema = log.schemas.get(channel.schema_id)
            if schema is not None and schema.id not in self._schemas:
                self._schemas[schema.id] = self._writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            self._channels[number] = self._writer.register_channel(
                channel.topic,
                channel.message_encoding,
                self._schemas.get(channel.schema_id, 0),
                channel.metadata,
            )
        return self._channels[number]
