"""A vehicle process: one agent on the Zenoh bus, or several."""

from __future__ import annotations

from collections.abc import Callable

import zenoh

from zenvoy.bus.connection import Wiring
from zenvoy.bus.hosts import Host
from zenvoy.bus.live import LiveBus
from zenvoy.bus.session import give_way
from zenvoy.bus.zenoh_bus import ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.hosted import HostedVehicles, LiveHostedVehicles
from zenvoy.vehicles.live import LiveVehicle
from zenvoy.vehicles.lock_step import LockStepVehicle


def run_vehicle(
    scenario: Scenario,
    vehicle: int,
    wiring: Wiring,
    on_joined: Callable[[zenoh.Session], None] = lambda _: None,
) -> None:
    """Drive one vehicle to the end of the run, in real time until asked to end; raises BusError.

    `on_joined` is called once the others know of the vehicle, before its first cycle.
    """
    if scenario.clock == "realtime":
        _drive(LiveBus(LiveVehicle(scenario, vehicle), wiring, scenario.speed), on_joined)
    else:
        _drive(ZenohBus(LockStepVehicle(scenario, vehicle), wiring), on_joined)


def run_host(scenario: Scenario, host: Host, wiring: Wiring) -> None:
    """Drive the vehicles of a process as `run_vehicle` drives one."""
    if scenario.clock == "realtime":
        _drive(LiveBus(LiveHostedVehicles(scenario, host), wiring, scenario.speed))
    else:
        _drive(ZenohBus(HostedVehicles(scenario, host), wiring))


def _drive(
    bus: ZenohBus | LiveBus, on_joined: Callable[[zenoh.Session], None] = lambda _: None
) -> None:
    with bus:
        on_joined(bus.session)
        if isinstance(bus, LiveBus):
            give_way()
        bus.run()
