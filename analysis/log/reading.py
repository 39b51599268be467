"""Reads all of a log in one pass, and checks it against what the log says about itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from google.protobuf.message import DecodeError

from zenvoy.analysis.log.checks import Content, checks_of
from zenvoy.analysis.log.columns import Table, stack
from zenvoy.analysis.log.cycles import Cycles
from zenvoy.analysis.log.facts import (
    Facts,
    metadata_of,
    printable,
    printable_values,
    scenario_of,
)
from zenvoy.analysis.log.laws import LoggedLaw, laws_in, own_laws_in, split_logged
from zenvoy.analysis.log.plausible import event_fault, fleet_fault, frames_fault, realtime_fault
from zenvoy.analysis.log.records import LogError, Message, Pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.log_format import EFFECTIVE, Fingerprint
from zenvoy.bus.log_metadata import LAWS, REPAIR, RUN, read_epoch_ns
from zenvoy.bus.packed import PackedCodec
from zenvoy.bus.topics import (
    CLOCK,
    ESTIMATE,
    EVENTS,
    FLEET_COMMAND,
    FRAMES,
    LOGGED,
    RADAR,
    REALTIME,
    TRUTH,
)
from zenvoy.scenarios import Scenario, modes

TABLES: Final = {
    topic.log_name: PackedCodec(topic.message.DESCRIPTOR)
    for topic in (TRUTH, RADAR, ESTIMATE, FLEET_COMMAND, CLOCK)
}
_STREAMED: Final = {
    FRAMES.log_name: (PackedCodec(FRAMES.message.DESCRIPTOR), frames_fault),
    REALTIME.log_name: (PackedCodec(REALTIME.message.DESCRIPTOR), realtime_fault),
}
_MAX_VEHICLE_BYTES: Final = 1_024  # per vehicle, in a message of a fleet topic


@dataclass(kw_only=True)
class Reading:
    """A log as it was read: the tables of its topics, its events, and its facts."""

    facts: Facts
    tables: dict[str, Table]
    events: list[pb.Event]
    frame_rows: int
    laws: dict[int, LoggedLaw]
    """Laws by mode."""
    law_units: dict[str, str]
    """Units of the columns that laws log."""


def read(path: Path) -> Reading:
    """Read the log at `path`, up to a cut or a gap; raises LogError."""
    with Pass(path) as log:  # this first pass is short: scenario and metadata are written first
        for _ in log.messages(None):
            if RUN in log.metadata and EFFECTIVE in log.attachments:
                break
    scenario = scenario_of(path, log)
    laws, of_laws = _laws(log, scenario)
    collector = _Collector(path, scenario, read_epoch_ns(log.metadata[RUN]), laws)
    with Pass(path, check=True) as log:
        for message in log.messages(None):
            collector.take(message)
    scenario = scenario_of(path, log)
    metadata = metadata_of(path, log, scenario)
    tables = {topic: collector.table(topic) for topic in TABLES}
    content = Content(
        cycles=collector.cycles,
        fingerprint=collector.fingerprint.hexdigest(),
        metadata_faults=(*metadata.faults, *of_laws),
    )
    facts = Facts(
        run=metadata.run,
        result=metadata.result,
        repair=printable_values(log.metadata.get(REPAIR, {})),
        laws=printable_values(own_laws_in(laws)),
        scenario=scenario,
        counts=_counts(log),
        whole=log.whole,
        read_cycles=collector.cycles[TRUTH.log_name].kept,
        checks=checks_of(log, scenario, content),
    )
    return Reading(
        facts=facts,
        tables=tables,
        events=collector.events_read(),
        frame_rows=collector.frame_rows,
        laws=laws,
        law_units=collector.law_units,
    )


def _laws(log: Pass, scenario: Scenario) -> tuple[dict[int, LoggedLaw], tuple[str, ...]]:
    """Return the laws by mode, and the faults in their description."""
    named = modes(scenario)
    try:
        return laws_in(log.metadata.get(LAWS, {}), named), ()
    except ValueError as error:
        return laws_in({}, named), (f"metadata {LAWS}: {printable(str(error))}",)


class _Collector:
    """Collects the messages of a log one by one; raises LogError for what no run can produce."""

    def __init__(
        self, path: Path, scenario: Scenario, epoch_ns: int, laws: Mapping[int, LoggedLaw]
    ) -> None:
        self._path = path
        self._laws = laws
        self.law_units: dict[str, str] = {}
        self._vehicles = scenario.fleet.size
        self._period_ns = scenario.period_ns
        self._epoch_ns = epoch_ns
        self._rows: dict[str, list[bytes]] = {topic: [] for topic in TABLES}
        self._events: list[pb.Event] = []
        self.cycles = {topic: Cycles(scenario.cycles) for topic in (*TABLES, FRAMES.log_name)}
        self.fingerprint = Fingerprint()
        self.frame_rows = 0

    def take(self, message: Message) -> None:
        """Add the next message of the log."""
        topic, payload = message.topic, message.payload
        self.fingerprint.add(topic, message.log_time_ns - self._epoch_ns, payload)
        if topic == EVENTS.log_name:
            self._events.append(self._event(payload))
        elif topic in TABLES:
            if len(payload) > _MAX_VEHICLE_BYTES * (1 + self._vehicles):
                raise LogError(
                    f"{self._path}: {topic}: a message has {len(payload)} bytes, "
                    f"too many for a fleet of {self._vehicles}"
                )
            if self.cycles[topic].take(payload):
                self._rows[topic].append(bytes(payload))
        elif topic in _STREAMED:
            cycles = self.cycles.get(topic)
            if cycles is None or cycles.take(payload):
                self._streamed(topic, payload)

    def table(self, topic: str) -> Table:
        """Return the table of a topic, with a row for each cycle up to the first gap."""
        try:
            table = stack(TABLES[topic], self._rows[topic])
            if topic == ESTIMATE.log_name:
                self.law_units = split_logged(table, self._laws, self._vehicles)
        except ValueError as error:
            raise LogError(f"{self._path}: {topic}: {error}") from error
        fault = fleet_fault(topic, table, self._vehicles)
        if fault is not None:
            raise LogError(f"{self._path}: {topic}: {fault}")
        return table

    def events_read(self) -> list[pb.Event]:
        """Return the events; where cycles are missing, up to the last row of /fleet/truth."""
        truth = self.cycles[TRUTH.log_name]
        if not truth.missing():
            return self._events
        last_ns = max(0, truth.kept - 1) * self._period_ns
        return [event for event in self._events if event.time_ns <= last_ns]

    def _streamed(self, topic: str, payload: memoryview) -> None:
        codec, fault_of = _STREAMED[topic]
        try:
            table = codec.decode(payload)
        except ValueError as error:
            raise LogError(f"{self._path}: {topic}: {error}") from error
        fault = fault_of(table, self._vehicles)
        if fault is not None:
            raise LogError(f"{self._path}: {topic}: {fault}")
        if topic == FRAMES.log_name:
            self.frame_rows += len(table["source"])

    def _event(self, payload: memoryview) -> pb.Event:
        try:
            event = pb.Event.FromString(bytes(payload))
        except DecodeError as error:
            raise LogError(f"{self._path}: {EVENTS.log_name}: {error}") from error
        fault = event_fault(event, self._vehicles)
        if fault is not None:
            raise LogError(f"{self._path}: {EVENTS.log_name}: {fault}")
        return event


def _counts(log: Pass) -> dict[str, int]:
    """Return the number of messages by topic, with Zenvoy's own topics first."""
    counts = {topic.log_name: 0 for topic in LOGGED}
    for channel, topic in log.topics.items():
        name = printable(topic)
        counts[name] = counts.get(name, 0) + log.counts[channel]
    return counts
