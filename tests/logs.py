"""Helpers write logs of small runs in this process, with the parts of a real run."""

from __future__ import annotations

from dataclasses import replace
from itertools import count
from pathlib import Path

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.clock import WallClock, wall_ns
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.topics import EVENTS
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.labels import labels_of
from zenvoy.scenarios import load
from zenvoy.world.recorder import Recorder


def chunk_every(cycles: int) -> WallClock:
    """Return a clock with which a log has a chunk for every `cycles` cycles."""
    ticks = count()
    return lambda: next(ticks) * (500_000_001 // cycles + 1)


class InterruptedRunError(Exception):
    """Raised between two messages of the log, as a signal does."""


def write_log(
    path: Path,
    scenario: str,
    *,
    until_cycle: int | None = None,
    lost: str = "",
    clock: WallClock = wall_ns,
) -> Path:
    """Run a scenario, given as YAML, and log it. The run is interrupted at `until_cycle`.

    `lost` is a process that the log then reports as lost.
    """
    source = path.with_suffix(".yaml")
    source.write_text(scenario)
    loaded = load(source)

    def interrupt(clock: pb.Clock) -> None:
        if clock.cycle == until_cycle:
            raise InterruptedRunError

    labels = replace(labels_of(loaded, "in-process", 1), run=path.stem)  # for equal bytes each time
    with Recorder(path, labels, clock) as recorder:
        recorder.on_clock = interrupt
        try:
            InProcessBus(agents_of(loaded.scenario), recorder.log).run()
        except InterruptedRunError:
            recorder.end = "stopped"
            if lost:
                event = pb.Event(time_ns=recorder.time_ns, kind=pb.EVENT_PROCESS_LOST, text=lost)
                recorder.log(EVENTS, event.time_ns, event.SerializeToString())
    return path
