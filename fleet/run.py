"""Runs a scenario and logs it in a folder: on processes of its own, or in this one."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.clock import wall_ns
from zenvoy.bus.in_process import InProcessBus
from zenvoy.bus.log_format import EFFECTIVE
from zenvoy.bus.text import utf8
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.agents import agents_of
from zenvoy.fleet.ends import Death
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, LOGS
from zenvoy.fleet.guests import FILE, NO_GUESTS, Guests, endpoints_of
from zenvoy.fleet.labels import labels_of
from zenvoy.fleet.limits import require_no_session, require_room_for
from zenvoy.fleet.progress import ClockReader, OnProgress, clock_to, progress_of
from zenvoy.fleet.rehearsal import rehearse
from zenvoy.fleet.requests import requests_to_end_handled_by
from zenvoy.fleet.sockets import socket_folder
from zenvoy.fleet.supervisor import Supervisor
from zenvoy.fleet.table import process_table
from zenvoy.laws.errors import LawError
from zenvoy.scenarios import Loaded, effective_json
from zenvoy.world.recorder import Recorder


class Interrupted(KeyboardInterrupt):
    """A signal has asked the command to end; `complete` says whether the run was over by then."""

    def __init__(self, *, complete: bool) -> None:
        super().__init__()
        self.complete = complete

    def __str__(self) -> str:
        kept = "the run was complete by then" if self.complete else "the log up to here is kept"
        return f"interrupted; {kept}"


def _ignore(_: object) -> None:
    """Do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Callbacks during a run; by default they do nothing.

    `on_loss` is called when a vehicle process dies and the run, in real time, goes on without it.
    """

    on_progress: OnProgress = _ignore
    on_loss: Callable[[Death], None] = _ignore


_NO_WATCH: Final = Watch()


def run(
    loaded: Loaded,
    folder: Path,
    engine: Engine,
    watch: Watch = _NO_WATCH,
    *,
    guests: Guests = NO_GUESTS,
    per_process: int = 1,
) -> Death | None:
    """Run a scenario and log it in a folder made by `make_folder`.

    Returns the death of the process that ended the run early, if any; its `complete` says whether
    the run is complete all the same. `guests` and `per_process`, the number of vehicles in a
    process, apply to the engine "processes" only. Raises Interrupted, and OSError if the system
    lacks disk, memory, processes or file descriptors for the run.
    """
    (folder / EFFECTIVE).write_bytes(utf8(effective_json(loaded.scenario)))
    if engine == "processes":
        return _run_on_processes(loaded, folder, watch, guests, per_process)
    try:
        _run_in_process(loaded, folder, watch)
    except LawError as error:
        return Death(error.process, f"died: {error}")
    return None


def _run_in_process(loaded: Loaded, folder: Path, watch: Watch) -> None:
    """Run the whole fleet in this process, without Zenoh."""
    scenario = loaded.scenario
    labels = labels_of(loaded, "in-process", scenario.fleet.size)

    def show(clock: pb.Clock) -> None:
        if clock.cycle % 10 == 0:  # show one message in ten, to save time
            watch.on_progress(progress_of(clock, scenario.duration_s))

    with Recorder(folder / LOG, labels, wall_ns) as recorder:
        recorder.on_clock = show
        agents = agents_of(scenario)
        recorder.start_clock()
        try:
            with _interrupted_between(recorder):
                InProcessBus(agents, recorder.log).run()
        except KeyboardInterrupt:
            recorder.end = "stopped"
            raise Interrupted(complete=False) from None


def _run_on_processes(
    loaded: Loaded, folder: Path, watch: Watch, guests: Guests, per_process: int
) -> Death | None:
    """Run world, channel and vehicles as processes.

    While they run, connect.json in the folder gives the endpoints for `guests` and others.
    """
    scenario = loaded.scenario
    require_no_session()
    require_room_for(len(vehicle_processes(scenario.fleet.size, per_process, guests.without)) + 2)
    sockets = socket_folder()  # the folder of the run may be too long for a socket's path
    labels = labels_of(loaded, "zenoh", per_process)
    endpoints = endpoints_of(labels.run, sockets, guests.listen)
    rehearse(scenario)
    reader = ClockReader()

    def show(data: bytes) -> None:
        for clock in reader.feed(data):
            watch.on_progress(progress_of(clock, scenario.duration_s))

    read_fd, write_fd = os.pipe()
    supervisor: Supervisor | None = None
    try:
        table = process_table(
            scenario,
            labels,
            folder / LOG,
            sockets,
            clock_to(write_fd),
            endpoints,
            guests.without,
            per_process,
        )
        endpoints.write(folder)
        supervisor = Supervisor(table, folder / LOGS, scenario.stall_limit_s)
        with supervisor:
            death = supervisor.watch(read_fd, show, watch.on_loss)
        return death._replace(complete=True) if death and supervisor.completed else death
    except KeyboardInterrupt:
        complete = supervisor is not None and supervisor.completed
        raise Interrupted(complete=complete) from None
    finally:
        os.close(read_fd)
        os.close(write_fd)
        (folder / FILE).unlink(missing_ok=True)  # nobody listens there any more
        shutil.rmtree(sockets, ignore_errors=True)


@contextmanager
def _interrupted_between(recorder: Recorder) -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP end the run between two messages of the log.

    The recorder's `on_clock` then raises KeyboardInterrupt.
    """
    asked = False
    show = recorder.on_clock

    def ask(_signal: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked = True

    def tick(clock: pb.Clock) -> None:
        show(clock)
        if asked:
            raise KeyboardInterrupt

    recorder.on_clock = tick
    with requests_to_end_handled_by(ask):
        yield
