"""The process table of a run: world, channel, and a row per vehicle."""

from __future__ import annotations

import os
import shutil
import signal
import socket
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.access import SERVERS, access_control
from zenvoy.bus.joining import OnArrival
from zenvoy.bus.topics import TRUTH, vehicle_name
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes
from zenvoy.bus.wiring import Wiring
from zenvoy.channel.process import run_channel
from zenvoy.fleet.certificates import certificate_of, doors_of, members_in
from zenvoy.fleet.guests import RunEndpoints
from zenvoy.fleet.priority import prefer_latency, prefer_throughput
from zenvoy.fleet.sockets import make_private
from zenvoy.fleet.spawn import Program
from zenvoy.laws import builtin
from zenvoy.laws.by_name import ESTIMATORS
from zenvoy.scenarios import Scenario, attendance, modes
from zenvoy.vehicles.process import run_vehicle, run_vehicles
from zenvoy.world.process import run_world
from zenvoy.world.recorder import Labels

# All processes notice a stall at once. The channel knows whose beacon is missing, while the world
# only misses commands, so the world waits longer and lets the channel report first.
_WORLD_PATIENCE: Final = 1.25
# The scenario's own code may hang for the stall limit. Its vehicle reports it, so both wait longer.
_CODE_PATIENCE: Final = 1.2


def process_table(
    scenario: Scenario,
    labels: Labels,
    log: Path,
    sockets: Path,
    on_clock: Callable[[pb.Clock], None],
    endpoints: RunEndpoints,
    without: frozenset[int] = frozenset(),
    per_process: int = 1,
    certs: Path | None = None,
    *,
    on_arrival: OnArrival,
    on_held_up: Callable[[str], None],
    all_elsewhere: bool = False,
    by_hand: socket.socket | None = None,
) -> list[Program]:
    """Return the programs of a run in the order of their start, except vehicles in `without`.

    In lock-step the run waits for those vehicles; in real time they may join at any time. `certs`
    is the folder of the certificates, if there is an endpoint with TLS. If all vehicles run
    elsewhere, world and channel wait for them without a limit. A router has the rules of access
    itself, and checks the certificates of all processes.
    """
    size = scenario.fleet.size
    vehicles = range(1, size + 1)
    realtime = scenario.clock == "realtime"
    remote = vehicle_processes(size, per_process) if all_elsewhere else ()
    placed = () if all_elsewhere else vehicle_processes(size, per_process, without)
    shared = tuple(process for process in (*placed, *remote) if process.is_shared)
    guests = tuple(vehicle_name(vehicle, size) for vehicle in sorted(without))
    awaited = (
        *(process.name for process in (*placed, *remote)),
        *(() if realtime else guests),
    )
    absent = without if realtime else frozenset[int]()
    has_own_code = scenario.estimator.kind not in ESTIMATORS.taken() or any(
        model not in builtin() for model in modes(scenario)
    )
    patience = _CODE_PATIENCE if has_own_code else 1.0
    clock_error_ns = scenario.max_clock_error_ns if realtime and all_elsewhere else 0
    public = frozenset({TRUTH.name} if scenario.public_truth else ())
    access: dict[str, object] = {}
    if certs is not None and not endpoints.router:
        protocols = dict.fromkeys(one.partition("/")[0] for one in endpoints.world)
        trusted = [one for one in protocols if one != "tls"]
        access = access_control(labels.run, size, shared, members_in(certs), trusted, public)
    doors = {name: doors_of(certs, name).guarded(access) for name in SERVERS} if certs else {}
    world_wiring = Wiring(
        run=labels.run,
        vehicles=vehicles,
        listen=() if endpoints.router else endpoints.world,
        connect=endpoints.connect if endpoints.router else (),
        router=endpoints.router,
        waits_for=("channel", *awaited),
        stall_limit_s=scenario.stall_limit_s * _WORLD_PATIENCE * patience,
        absent=absent,
        shared_processes=shared,
        public=public,
        doors=doors.get("world"),
        patient=all_elsewhere,
        clock_error_ns=clock_error_ns,
    )
    channel_wiring = Wiring(
        run=labels.run,
        vehicles=vehicles,
        listen=() if endpoints.router else endpoints.channel,
        router=endpoints.router,
        connect=endpoints.connect[:1],
        waits_for=awaited,
        stall_limit_s=scenario.stall_limit_s * patience,
        absent=absent,
        shared_processes=shared,
        doors=doors.get("channel"),
        patient=all_elsewhere,
        clock_error_ns=clock_error_ns,
    )
    wiring = Wiring(
        run=labels.run,
        vehicles=vehicles,
        connect=endpoints.connect,
        shared_processes=shared,
        router=endpoints.router,
    )

    def wiring_of(process: VehicleProcess) -> Wiring:
        if certs is None or not endpoints.router:
            return wiring
        return replace(wiring, doors=doors_of(certs, certificate_of(process)))

    row = partial(Program, run=labels.run, prefer=prefer_latency if realtime else prefer_throughput)
    return [
        row(
            name="world",
            main=partial(
                _in_cleaned_up,
                os.getpid(),
                sockets,
                run_world,
                scenario,
                labels,
                log,
                world_wiring,
                on_clock,
                on_arrival,
                on_held_up,
                by_hand,
            ),
            on_orphaned=signal.SIGTERM,  # so that it finishes the log
        ),
        row(name="channel", main=partial(_in_private, sockets, scenario, channel_wiring)),
        *(
            _of_vehicles(
                process, scenario, wiring_of(process), partial(row, essential=not realtime)
            )
            for process in placed
        ),
    ]


def _of_vehicles(
    process: VehicleProcess, scenario: Scenario, wiring: Wiring, row: Callable[..., Program]
) -> Program:
    """Return the program of a vehicle process, with those that follow it when it is killed.

    A shared process lives on when one of its vehicles is killed.
    """
    if process.is_shared:
        return row(name=process.name, main=partial(run_vehicles, scenario, process, wiring))
    (vehicle,) = process.vehicles
    kills = attendance(scenario).kills(vehicle)
    if not kills:
        return row(name=process.name, main=partial(run_vehicle, scenario, vehicle, wiring))
    successor: Program | None = None
    for life in range(len(kills), -1, -1):
        is_last = life == len(kills)
        if is_last and kills[-1].end >= scenario.cycles:
            continue  # nobody comes back
        successor = row(
            name=process.name,
            main=partial(run_vehicle, scenario, vehicle, wiring, life=life),
            killed_with="" if is_last else f"killed by fault {life + 1} of the vehicle",
            successor=successor,
        )
    assert successor is not None
    return successor


def _in_private(sockets: Path, scenario: Scenario, wiring: Wiring) -> None:
    make_private(sockets)
    run_channel(scenario, wiring)


def _in_cleaned_up(
    parent: int, sockets: Path, main: Callable[..., None], *arguments: object
) -> None:
    """Run `main`, then remove the folder of sockets, in case the parent has been killed.

    After an error, leave the folder to a parent that is alive: another process would fail without
    the folder, and would be blamed.
    """
    succeeded = False
    try:
        make_private(sockets)
        main(*arguments)
        succeeded = True
    finally:
        if succeeded or os.getppid() != parent:
            shutil.rmtree(sockets, ignore_errors=True)
