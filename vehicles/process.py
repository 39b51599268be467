"""A vehicle process: one agent on the Zenoh bus."""

from __future__ import annotations

from zenvoy.bus.live import LiveBus
from zenvoy.bus.zenoh_bus import Wiring, ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.agent import VehicleAgent
from zenvoy.vehicles.live import LiveVehicle


def run_vehicle(scenario: Scenario, vehicle: int, wiring: Wiring) -> None:
    """Drive one vehicle to the end of the run, in real time until asked to end; raises BusError."""
    if scenario.clock == "realtime":
        with LiveBus(LiveVehicle(scenario, vehicle), wiring, scenario.speed) as live:
            live.run()
        return
    with ZenohBus(VehicleAgent(scenario, vehicle), wiring) as bus:
        bus.run()
