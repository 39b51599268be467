"""Writes a run to an MCAP file while it goes on, and computes its fingerprint."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from mcap.well_known import MessageEncoding, SchemaEncoding

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.clock import WallClock
from zenvoy.bus.log_format import EFFECTIVE, EPOCH_NS, SCENARIO, Fingerprint
from zenvoy.bus.log_metadata import LAWS, RESULT, RUN, ResultMetadata, RunMetadata, sealed
from zenvoy.bus.log_writer import LogWriter
from zenvoy.bus.scene import SCENE_TOPICS, Scene, Stage
from zenvoy.bus.schemas import schema_of
from zenvoy.bus.topics import CLOCK, LOGGED, TRUTH, Topic

# If the world is killed, at most 0.5 s are lost: this and a cycle of real time.
_FLUSH_NS: Final = 350_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Labels:
    """What the log says about its run."""

    scenario_name: str
    scenario_text: str
    effective_json: str
    seed: int
    cycles: int
    period_ns: int
    vehicles: int
    bus: str
    run: str
    per_process: int
    notes: tuple[str, ...] = ()
    """Notes on the scenario, one line each."""
    laws: Mapping[str, str] = field(default_factory=dict)
    """Facts about the scenario's own laws, by mode."""
    stage: Stage | None = None
    """What the log's scene shows; None for a log without one."""


class Recorder:
    """The log of one run, to be used as a context manager, which finishes the file properly.

    `on_clock` gets the clock message of every cycle, to publish it and to show progress.
    `overruns` returns how many cycles have begun late so far. `held_up` returns in words which
    machine has held up the run, given its wall time, ns. Wall time counts from `start_clock`, which
    entering the context calls first.
    """

    def __init__(self, path: Path, labels: Labels, clock: WallClock) -> None:
        self._labels = labels
        self._clock = clock
        self.on_clock: Callable[[pb.Clock], None] = lambda _: None
        self.overruns: Callable[[], int] = lambda: 0
        self.held_up: Callable[[int], str] = lambda _: ""
        self._start_ns = self._flushed_ns = 0
        self._last = pb.Clock()
        self._fingerprint = Fingerprint()
        self._file = path.open("wb")
        self._writer = LogWriter(self._file)
        self._channels: dict[str, int] = {}
        self._scene = None if labels.stage is None else Scene(labels.stage)
        self.end = "complete"

    def __enter__(self) -> Self:
        self._writer.start(profile="", library=f"zenvoy {version('zenvoy')}")
        self._writer.add_metadata(RUN, sealed(metadata_of(self._labels).written()))
        if self._labels.laws:
            self._writer.add_metadata(LAWS, sealed(self._labels.laws))
        self._attach(SCENARIO, "application/yaml", self._labels.scenario_text)
        self._attach(EFFECTIVE, "application/json", self._labels.effective_json)
        for topic in LOGGED:
            self._register(topic.log_name, topic.message.DESCRIPTOR.full_name)
        if self._scene is not None:
            for name, message in SCENE_TOPICS.items():
                self._register(name, message)
        self._writer.flush()
        self.start_clock()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is not None and self.end == "complete":
            self.end = f"{type(error).__name__}: {error}"
        self.close()

    def close(self) -> None:
        """Write the result and finish the file, unless it is already finished."""
        if self._file.closed:
            return
        self._writer.flush()  # the result comes after all messages
        self._writer.add_metadata(RESULT, sealed(self.result()))
        self._writer.finish()
        self._file.close()

    @property
    def time_ns(self) -> int:
        """The simulation time of the last cycle logged."""
        return int(self._last.time_ns)

    def start_clock(self, at_ns: int | None = None) -> None:
        """Count wall time from an instant of the wall clock, or from now."""
        self._start_ns = self._flushed_ns = self._clock() if at_ns is None else at_ns

    def log(self, topic: Topic[Any], time_ns: int, payload: bytes) -> None:
        """Write one message with its simulation time."""
        self._fingerprint.add(topic.log_name, time_ns, payload)
        if topic.log_name not in self._channels:
            self._register(topic.log_name, topic.message.DESCRIPTOR.full_name)
        self._write(topic.log_name, time_ns, payload)
        if self._scene is not None:
            for name, drawn in self._scene.take(topic.log_name, payload).items():
                self._write(name, time_ns, drawn)
        if topic is TRUTH:
            self._tick(time_ns)

    def result(self) -> dict[str, str]:
        """Return the current entries of zenvoy.result."""
        return ResultMetadata(
            end=self.end,
            fingerprint=self._fingerprint.hexdigest(),
            cycles=self._last.cycle,
            clock=self._last,
            held_up=self.held_up(self._last.wall_ns),
        ).written()

    def _tick(self, time_ns: int) -> None:
        """Log the wall time of this cycle, and flush the file if it is due."""
        now_ns = self._clock()
        wall_ns = now_ns - self._start_ns
        self._last = pb.Clock(
            cycle=time_ns // self._labels.period_ns,
            time_ns=time_ns,
            wall_ns=wall_ns,
            real_time_factor=time_ns / wall_ns if wall_ns else 0.0,
            overruns=self.overruns(),
        )
        self._write(CLOCK.log_name, time_ns, self._last.SerializeToString())
        self.on_clock(self._last)
        self._flush_if_due(now_ns)

    def flush_if_due(self) -> None:
        """Flush the file if the last flush is too long ago; called while the world waits."""
        self._flush_if_due(self._clock())

    def _flush_if_due(self, now_ns: int) -> None:
        if now_ns - self._flushed_ns > _FLUSH_NS:
            self._writer.flush()
            self._flushed_ns = now_ns

    def _register(self, topic: str, message: str) -> None:
        schema = self._writer.register_schema(message, SchemaEncoding.Protobuf, schema_of(message))
        self._channels[topic] = self._writer.register_channel(
            topic, MessageEncoding.Protobuf, schema
        )

    def _write(self, topic: str, time_ns: int, payload: bytes) -> None:
        at_ns = EPOCH_NS + time_ns
        self._writer.add_message(self._channels[topic], at_ns, payload, at_ns)

    def _attach(self, name: str, media_type: str, text: str) -> None:
        self._writer.add_attachment(EPOCH_NS, EPOCH_NS, name, media_type, text.encode())


def metadata_of(labels: Labels) -> RunMetadata:
    """Return the metadata of the run: its scenario, sizes, bus, machine and versions."""
    return RunMetadata(
        scenario=labels.scenario_name,
        seed=labels.seed,
        cycles=labels.cycles,
        period_ns=labels.period_ns,
        vehicles=labels.vehicles,
        bus=labels.bus,
        run=labels.run,
        vehicles_per_process=labels.per_process,
        notes=labels.notes,
        python=platform.python_version(),
        machine=f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        versions=_versions(),
    )


@cache
def _versions() -> dict[str, str]:
    packages = ("zenvoy", "eclipse-zenoh", "numpy", "filterpy", "mcap", "protobuf")
    return {name: version(name) for name in packages}
