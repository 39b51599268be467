"""The vehicles of a run that this machine drives."""

from __future__ import annotations

import os
import re
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import zenoh
from pydantic import ValidationError

from zenvoy.bus.clock_bounds import Offset
from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import NoAnswerError, SeveralRunsError, StoppedError
from zenvoy.bus.joining import at_end
from zenvoy.bus.topics import host_key, plain_name, vehicle_name
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.bus.wiring import Wiring
from zenvoy.fleet.asking import ask_in_child
from zenvoy.fleet.certificates import doors_of
from zenvoy.fleet.ends import Death
from zenvoy.fleet.interruption import Interrupted
from zenvoy.fleet.join import JoinError, ask_to_end, load_code
from zenvoy.fleet.priority import prefer_latency, prefer_throughput
from zenvoy.fleet.spawn import Program
from zenvoy.fleet.supervisor import Supervisor
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.preparation import prepare
from zenvoy.vehicles.process import run_vehicle, run_vehicles

_NOT_PLAIN: Final = re.compile(r"[^\w.-]", re.ASCII)


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """The processes of a run that this machine starts, and how they enter."""

    run: str
    connect: tuple[str, ...]
    scenario: Scenario
    processes: tuple[VehicleProcess, ...]
    shared: tuple[VehicleProcess, ...]  # of the whole run
    doors: Mapping[str, Doors]  # by process
    host: str
    router: bool = False  # whether `connect` is a Zenoh router


def find_share(
    vehicles: range,
    run: str | None,
    connect: Sequence[str],
    limit_s: float,
    certs: Path | None,
    *,
    per_process: int | None = None,
    host: str | None = None,
    router: bool = False,
    allow_code: bool = False,
) -> Share:
    """Ask a run (None: the only one) for its scenario, and return the share with these vehicles.

    Raises JoinError, CertificatesError.
    """
    try:
        plain_name("any" if run is None else run)
    except ValueError as error:
        raise JoinError(f"--run: {error}") from error
    group = f"vehicles-{vehicles[0]}-{vehicles[-1]}"
    if certs is None or len(vehicles) == 1 or not (certs / f"{group}.pem").exists():
        group = f"vehicle-{vehicles[0]}"
    first = None if certs is None else doors_of(certs, group)
    try:
        state = ask_in_child(run, connect, limit_s, first, router=router)
        run = state.run
        scenario = Scenario.model_validate_json(state.scenario)
    except SeveralRunsError as error:
        raise JoinError(f"--run: is needed, because {error}") from error
    except NoAnswerError as error:
        raise JoinError(str(error) if run is None else f"--run {run}: {error}") from error
    except ValidationError as error:
        raise JoinError(f"--run {run}: its scenario is from another version of Zenvoy") from error
    name = _NOT_PLAIN.sub("-", host or socket.gethostname())[:100] or "unnamed"
    if scenario.clock == "realtime":
        _require_clock(state.clock, scenario, run, name)
    shared = tuple(VehicleProcess(name, tuple(ids)) for name, ids in state.shared.items())
    processes = _processes_of(vehicles, scenario.fleet.size, shared)
    _check(processes, state.present, per_process)
    load_code(scenario, allow_code)
    doors: dict[str, Doors] = {}
    if certs is not None:
        for process in processes:
            own = f"vehicle-{process.vehicles[0]}" if group.startswith("vehicle-") else group
            if process.is_shared and own != group:
                raise JoinError(
                    f"--certs {certs}: has no vehicles-{vehicles[0]}-{vehicles[-1]}.pem, which the "
                    f"process {process.name} needs; zenvoy certs --group makes it"
                )
            doors[process.name] = doors_of(certs, own)
    return Share(
        run=run,
        connect=tuple(connect),
        scenario=scenario,
        processes=processes,
        shared=shared,
        doors=doors,
        router=router,
        host=name,
    )


def _require_clock(clock: Offset | None, scenario: Scenario, run: str, host: str) -> None:
    """Raise JoinError if this machine knows the world's clock worse than the scenario allows."""
    allowed = f"allowed: at most max_clock_error_ms ({scenario.max_clock_error_ms:g})"
    if clock is None:
        raise JoinError(f"--run {run}: the world does not tell its time")
    if clock.error_ns > scenario.max_clock_error_ns:
        raise JoinError(
            f"--run {run}: {host} knows the world's clock to ± {clock.error_ns * 1e-6:.3g} ms, "
            f"half a round trip; {allowed}"
        )


def _processes_of(
    vehicles: range, size: int, shared: Sequence[VehicleProcess]
) -> tuple[VehicleProcess, ...]:
    """Return the processes of the run with these vehicles; raises JoinError for parts of one."""
    if not 1 <= vehicles[0] <= vehicles[-1] <= size:
        ends = f"{vehicles[0]}-{vehicles[-1]}"
        raise JoinError(f"--vehicles {ends}: is not in [1, {size}], the vehicles of the run")
    found = [process for process in shared if set(process.vehicles) & set(vehicles)]
    for process in found:
        if not set(process.vehicles) <= set(vehicles):
            raise JoinError(
                f"--vehicles {vehicles[0]}-{vehicles[-1]}: has only a part of the process "
                f"{process.name}; allowed: all of its vehicles or none"
            )
    placed = {vehicle for process in found for vehicle in process.vehicles}
    alone = [one for one in vehicles if one not in placed]
    found += [VehicleProcess(vehicle_name(one, size), (one,)) for one in alone]
    return tuple(sorted(found, key=lambda process: process.vehicles))


def _check(
    processes: Sequence[VehicleProcess], present: frozenset[str], per_process: int | None
) -> None:
    """Raise JoinError if a process is there already, or the run has other processes than asked."""
    for process in processes:
        if process.name in present:
            raise JoinError(f"--vehicles: {process.name} is in the run already")
    largest = max(len(process.vehicles) for process in processes)
    if per_process is not None and largest > per_process:
        raise JoinError(
            f"--vehicles-per-process {per_process}: the run has {largest}; zenvoy serve sets it "
            "for all machines"
        )


def run_share(
    share: Share,
    logs: Path,
    on_started: Callable[[], None],
    on_loss: Callable[[Death], None] = lambda _: None,
) -> Death | None:
    """Drive the vehicles of a share to the end of the run; return a process that died first.

    In real time the others go on without it, and `on_loss` is called. Raises Interrupted, and
    OSError if the system lacks something for it.
    """
    realtime = share.scenario.clock == "realtime"
    programs = [
        Program(
            name=process.name,
            run=share.run,
            main=partial(_drive, share, process),
            prefer=prefer_latency if realtime else prefer_throughput,
            essential=not realtime,
        )
        for process in share.processes
    ]
    prepare(share.scenario)
    read_fd, write_fd = os.pipe()  # nothing is reported through it
    supervisor = Supervisor(programs, logs, share.scenario.stall_limit_s, all_lead=True)
    try:
        with supervisor:
            on_started()
            return supervisor.watch(read_fd, lambda _: False, on_loss)
    except KeyboardInterrupt:
        raise Interrupted(complete=supervisor.completed) from None
    finally:
        os.close(read_fd)
        os.close(write_fd)


def _drive(share: Share, process: VehicleProcess) -> None:
    """Drive the vehicles of a process to the end of the run; raises BusError.

    It waits for the rest of the fleet without a limit, and ends when the world does.
    """
    ended = threading.Event()
    kept: list[object] = []

    def end() -> None:
        ended.set()
        ask_to_end()

    def begin(session: zenoh.Session) -> None:
        key = host_key(share.run, process.name, share.host)
        kept.append(session.liveliness().declare_token(key))
        kept.append(at_end(session, share.run, end))

    wiring = Wiring(
        run=share.run,
        vehicles=range(1, share.scenario.fleet.size + 1),
        connect=share.connect,
        shared_processes=share.shared,
        router=share.router,
        doors=share.doors.get(process.name),
        far=True,
        clock_error_ns=share.scenario.max_clock_error_ns,
    )
    try:
        if process.is_shared:
            run_vehicles(share.scenario, process, wiring, begin)
        else:
            run_vehicle(share.scenario, process.vehicles[0], wiring, begin)
    except StoppedError:
        if not ended.is_set():
            raise
