"""Runs a whole fleet in this process, without Zenoh: by its agents, or as arrays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, Literal

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.agent import Log
from zenvoy.bus.clock import wall_ns
from zenvoy.bus.in_process import InProcessBus
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.arrays.batch import Batch
from zenvoy.fleet.arrays.log import RunLog
from zenvoy.fleet.interruption import Interrupted, interrupted_between
from zenvoy.fleet.labels import labels_of
from zenvoy.fleet.progress import OnProgress, progress_of
from zenvoy.scenarios import Loaded, Scenario
from zenvoy.world.recorder import Recorder

Alone = Literal["in-process", "arrays"]
"""The engines that need no other process."""


def run_alone(loaded: Loaded, log: Path, engine: Alone, on_progress: OnProgress) -> None:
    """Run a scenario to its end and log it.

    Raises Interrupted, LawError, OSError, and NotCoveredError where arrays cannot go on.
    """
    scenario = loaded.scenario
    labels = labels_of(loaded, engine, scenario.fleet.size)

    def show(clock: pb.Clock) -> None:
        if clock.cycle % 10 == 0:  # show one message in ten, to save time
            on_progress(progress_of(clock, scenario.duration_s))

    with Recorder(log, labels, wall_ns) as recorder:
        recorder.on_clock = show
        drive = _DRIVERS[engine](scenario, recorder.log)
        recorder.start_clock()
        try:
            with interrupted_between(recorder):
                drive()
        except KeyboardInterrupt:
            recorder.end = "stopped"
            raise Interrupted(complete=False) from None


def _by_agents(scenario: Scenario, log: Log) -> Callable[[], None]:
    return InProcessBus(agents_of(scenario), log).run


def _as_arrays(scenario: Scenario, log: Log) -> Callable[[], None]:
    batch = Batch((scenario,), whole=True)
    taken = RunLog(batch, 0, log)

    def drive() -> None:
        for cycle in batch.cycles():
            taken.take(cycle)
            if taken.stopped:
                return

    return drive


_DRIVERS: Final[dict[Alone, Callable[[Scenario, Log], Callable[[], None]]]] = {
    "in-process": _by_agents,
    "arrays": _as_arrays,
}
