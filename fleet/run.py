"""Runs a scenario and logs it in a folder: on processes of its own, or in this one."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from zenvoy.bus.errors import VehicleLostError
from zenvoy.bus.log_format import EFFECTIVE
from zenvoy.bus.text import utf8
from zenvoy.bus.vehicle_processes import vehicle_processes
from zenvoy.fleet.alone import run_alone
from zenvoy.fleet.ends import Death
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, LOGS
from zenvoy.fleet.guests import FILE, NO_GUESTS, Guests, RunEndpoints, endpoints_of
from zenvoy.fleet.interruption import Interrupted
from zenvoy.fleet.labels import labels_of
from zenvoy.fleet.limits import require_no_session, require_room_for
from zenvoy.fleet.progress import (
    Arrival,
    HeldUp,
    OnProgress,
    ReportReader,
    arrivals_to,
    clock_to,
    held_up_to,
    progress_of,
)
from zenvoy.fleet.rehearsal import rehearse
from zenvoy.fleet.sockets import socket_folder
from zenvoy.fleet.supervisor import Supervisor
from zenvoy.fleet.table import process_table
from zenvoy.laws.errors import LawError
from zenvoy.scenarios import Loaded, effective_json
from zenvoy.vehicles.arrays.refusal import NotCoveredError


def _ignore(_: object) -> None:
    """Do nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Callbacks during a run; by default they do nothing.

    `on_endpoints` is called before processes start, `on_arrival` when one has come or gone,
    `on_held_up` now and then with a sentence on the machine that holds up the run ("": none), and
    `on_idle` when nothing has happened for half a second.
    `on_loss` is called when a vehicle process dies and the run, in real time, goes on without it.
    `on_bad_end` is called if the world cannot finish the log of a run that ends early.
    """

    on_progress: OnProgress = _ignore
    on_loss: Callable[[Death], None] = _ignore
    on_endpoints: Callable[[RunEndpoints], None] = _ignore
    on_arrival: Callable[[Arrival], None] = _ignore
    on_held_up: Callable[[str], None] = _ignore
    on_idle: Callable[[], None] = lambda: None
    on_bad_end: Callable[[Death], None] = _ignore


_NO_WATCH: Final = Watch()


def run(
    loaded: Loaded,
    folder: Path,
    engine: Engine,
    watch: Watch = _NO_WATCH,
    *,
    guests: Guests = NO_GUESTS,
    per_process: int = 1,
    by_hand: socket.socket | None = None,
) -> Death | None:
    """Run a scenario and log it in a folder made by `make_folder`.

    The engine "arrays" runs only what `fleet.choice` allows. Returns the death of the process that
    ended the run early, if any; its `complete` says whether the run is complete all the same.
    `guests` and `per_process`, the number of vehicles in a process, apply to the engine "processes"
    only; so does `by_hand`, through which the world takes requests (`bus.by_hand`). Raises
    Interrupted, and OSError if the system lacks disk, memory, processes or file descriptors for the
    run.
    """
    (folder / EFFECTIVE).write_bytes(utf8(effective_json(loaded.scenario)))
    if engine == "processes":
        return _run_on_processes(loaded, folder, watch, guests, per_process, by_hand)
    try:
        run_alone(loaded, folder / LOG, engine, watch.on_progress)
    except LawError as error:
        return Death(error.process, f"died: {error}")
    except VehicleLostError as error:
        return Death(error.name, f"died: {error}")
    except NotCoveredError as error:
        return Death("the array engine", f"cannot go on: {error}; in-process can")
    return None


def _run_on_processes(
    loaded: Loaded,
    folder: Path,
    watch: Watch,
    guests: Guests,
    per_process: int,
    by_hand: socket.socket | None,
) -> Death | None:
    """Run world, channel and vehicles as processes.

    While they run, connect.json in the folder gives the endpoints for `guests` and others.
    """
    scenario = loaded.scenario
    require_no_session()
    require_room_for(len(vehicle_processes(scenario.fleet.size, per_process, guests.without)) + 2)
    sockets = socket_folder()  # the folder of the run may be too long for a socket's path
    labels = labels_of(loaded, "zenoh", per_process)
    endpoints = endpoints_of(labels.run, sockets, guests.listen, guests.router)
    rehearse(scenario)
    reader = ReportReader()

    def show(data: bytes) -> bool:
        begun = False
        for report in reader.feed(data):
            if isinstance(report, Arrival):
                watch.on_arrival(report)
            elif isinstance(report, HeldUp):
                watch.on_held_up(report.text)
            else:
                watch.on_progress(progress_of(report, scenario.duration_s))
                begun = True
        return begun

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
            guests.certs,
            on_arrival=arrivals_to(write_fd),
            on_held_up=held_up_to(write_fd),
            all_elsewhere=guests.all_elsewhere,
            by_hand=by_hand,
        )
        endpoints.write(folder)
        watch.on_endpoints(endpoints)
        supervisor = Supervisor(table, folder / LOGS, scenario.stall_limit_s)
        with supervisor:
            death = supervisor.watch(read_fd, show, watch.on_loss, watch.on_idle)
        return death._replace(complete=True) if death and supervisor.completed else death
    except KeyboardInterrupt:
        complete = supervisor is not None and supervisor.completed
        raise Interrupted(complete=complete) from None
    finally:
        for bad_end in () if supervisor is None else supervisor.bad_ends:
            watch.on_bad_end(bad_end)
        os.close(read_fd)
        os.close(write_fd)
        (folder / FILE).unlink(missing_ok=True)  # nobody listens there any more
        shutil.rmtree(sockets, ignore_errors=True)
