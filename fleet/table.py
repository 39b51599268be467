"""The process table of a run: world, channel, and a row per vehicle."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.connection import Wiring
from zenvoy.bus.topics import vehicle_name
from zenvoy.bus.vehicle_processes import VehicleProcess, vehicle_processes
from zenvoy.channel.process import run_channel
from zenvoy.fleet.guests import Meeting
from zenvoy.fleet.priority import prefer_latency, prefer_throughput
from zenvoy.fleet.sockets import make_private
from zenvoy.fleet.spawn import Program
from zenvoy.laws import builtin
from zenvoy.laws.by_name import ESTIMATORS
from zenvoy.scenarios import Scenario, modes
from zenvoy.vehicles.process import run_vehicle, run_vehicles
from zenvoy.world.process import run_world
from zenvoy.world.recorder import Labels

# A stall shows everywhere at once. Who waits for a vehicle's beacon knows more than who waits for
# all the commands, so the channel is given the chance to speak first.
_WORLD_PATIENCE: Final = 1.25
# Code of the scenario's own that hangs for the stall limit is to be named, and not its vehicle.
_CODE_PATIENCE: Final = 1.2


def process_table(
    scenario: Scenario,
    labels: Labels,
    log: Path,
    sockets: Path,
    on_clock: Callable[[pb.Clock], None],
    met: Meeting,
    without: frozenset[int] = frozenset(),
    per_process: int = 1,
) -> list[Program]:
    """Programs of a run but for the vehicles it is `without`, in the order in which they start.

    In lock-step these are waited for all the same; in real time they may join at any time.
    """
    size = scenario.fleet.size
    vehicles = range(1, size + 1)
    realtime = scenario.clock == "realtime"
    placed = vehicle_processes(size, per_process, without)
    shared = tuple(process for process in placed if process.is_shared)
    guests = tuple(vehicle_name(vehicle, size) for vehicle in sorted(without))
    awaited = (*(process.name for process in placed), *(() if realtime else guests))
    absent = without if realtime else frozenset[int]()
    has_own_code = scenario.estimator.kind not in ESTIMATORS.taken() or any(
        model not in builtin() for model in modes(scenario)
    )
    patience = _CODE_PATIENCE if has_own_code else 1.0
    world_wiring = Wiring(
        run=labels.run,
        vehicles=vehicles,
        listen=met.world,
        waits_for=("channel", *awaited),
        stall_limit_s=scenario.stall_limit_s * _WORLD_PATIENCE * patience,
        absent=absent,
        shared_processes=shared,
    )
    channel_wiring = Wiring(
        run=labels.run,
        vehicles=vehicles,
        listen=met.channel,
        connect=met.connect[:1],
        waits_for=awaited,
        stall_limit_s=scenario.stall_limit_s * patience,
        absent=absent,
        shared_processes=shared,
    )
    wiring = Wiring(run=labels.run, vehicles=vehicles, connect=met.connect, shared_processes=shared)
    row = partial(Program, run=labels.run, prefer=prefer_latency if realtime else prefer_throughput)
    return [
        row(
            name="world",
            main=partial(
                _tidied,
                os.getpid(),
                sockets,
                run_world,
                scenario,
                labels,
                log,
                world_wiring,
                on_clock,
            ),
            on_orphaned=signal.SIGTERM,  # it ends the log first
        ),
        row(name="channel", main=partial(_in_private, sockets, scenario, channel_wiring)),
        *(
            row(name=process.name, main=_of(process, scenario, wiring), essential=not realtime)
            for process in placed
        ),
    ]


def _of(process: VehicleProcess, scenario: Scenario, wiring: Wiring) -> Callable[[], None]:
    if process.is_shared:
        return partial(run_vehicles, scenario, process, wiring)
    return partial(run_vehicle, scenario, process.vehicles[0], wiring)


def _in_private(sockets: Path, scenario: Scenario, wiring: Wiring) -> None:
    make_private(sockets)
    run_channel(scenario, wiring)


def _tidied(parent: int, sockets: Path, main: Callable[..., None], *arguments: object) -> None:
    """Run `main` and remove the folder of sockets, which a parent that is killed cannot do.

    After an error a parent that lives removes it, so that no other process trips over its absence
    and is blamed.
    """
    over = False
    try:
        make_private(sockets)
        main(*arguments)
        over = True
    finally:
        if over or os.getppid() != parent:
            shutil.rmtree(sockets, ignore_errors=True)
