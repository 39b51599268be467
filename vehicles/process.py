"""A vehicle process: one agent on the Zenoh bus."""

from __future__ import annotations

from collections.abc import Callable

import zenoh

from zenvoy.bus.connection import Wiring
from zenvoy.bus.live import LiveBus
from zenvoy.bus.session import give_way
from zenvoy.bus.zenoh_bus import ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.agent import VehicleAgent
from zenvoy.vehicles.live import LiveVehicle


def run_vehicle(
    scenario: Scenario,
    vehicle: int,
    wiring: Wiring,
    on_joined: Callable[[zenoh.Session], None] = lambda _: None,
) -> None:
    """Drive one vehicle to the end of the run, in real time until asked to end; raises BusError.

    `on_joined` is called once the others know of the vehicle, before its first cycle.
    """
    bus: ZenohBus | LiveBus
    if scenario.clock == "realtime":
        bus = LiveBus(LiveVehicle(scenario, vehicle), wiring, scenario.speed)
    else:
        bus = ZenohBus(VehicleAgent(scenario, vehicle), wiring)
    with bus:
        on_joined(bus.session)
        if isinstance(bus, LiveBus):
            give_way()
        bus.run()
