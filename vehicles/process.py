"""A vehicle process: one agent on the Zenoh bus, or several."""

from __future__ import annotations

from collections.abc import Callable

import zenoh

from zenvoy.bus.realtime import RealtimeBus
from zenvoy.bus.session import give_way
from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.bus.wiring import Wiring
from zenvoy.bus.zenoh_bus import ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.suited import suited
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.vehicles.realtime import RealtimeVehicle
from zenvoy.vehicles.realtime_arrays import RealtimeArrayVehicles
from zenvoy.vehicles.shared_arrays import ArrayVehicles
from zenvoy.vehicles.shared_process import LockStepVehicles, RealtimeVehicles


def run_vehicle(
    scenario: Scenario,
    vehicle: int,
    wiring: Wiring,
    on_joined: Callable[[zenoh.Session], None] = lambda _: None,
    life: int | None = None,
) -> None:
    """Drive one vehicle to the end of the run; in real time, until it is asked to end.

    `on_joined` is called once the others know of the vehicle, before its first cycle. `life` is
    the number of its process, if the scenario kills one. Raises BusError.
    """
    if scenario.clock == "realtime":
        _drive(
            RealtimeBus(RealtimeVehicle(scenario, vehicle, life), wiring, scenario.speed), on_joined
        )
    else:
        _drive(ZenohBus(LockStepVehicle(scenario, vehicle, life), wiring), on_joined)


def run_vehicles(
    scenario: Scenario,
    process: VehicleProcess,
    wiring: Wiring,
    on_joined: Callable[[zenoh.Session], None] = lambda _: None,
) -> None:
    """Drive the vehicles of a process as `run_vehicle` drives one, as arrays if these can."""
    known = {vehicle for shared in wiring.shared_processes for vehicle in shared.vehicles}
    as_arrays = suited(scenario, process.vehicles, known)
    if scenario.clock == "realtime":
        in_real_time = RealtimeArrayVehicles if as_arrays else RealtimeVehicles
        bus = RealtimeBus(in_real_time(scenario, process), wiring, scenario.speed)
        _drive(bus, on_joined)
    else:
        in_lock_step = ArrayVehicles if as_arrays else LockStepVehicles
        _drive(ZenohBus(in_lock_step(scenario, process), wiring), on_joined)


def _drive(
    bus: ZenohBus | RealtimeBus, on_joined: Callable[[zenoh.Session], None] = lambda _: None
) -> None:
    with bus:
        on_joined(bus.session)
        if isinstance(bus, RealtimeBus):
            give_way()
        bus.run()
