"""A vehicle process: one agent on the Zenoh bus."""

from __future__ import annotations

from zenvoy.bus.zenoh_bus import Wiring, ZenohBus
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.agent import VehicleAgent


def run_vehicle(scenario: Scenario, vehicle: int, wiring: Wiring) -> None:
    """Drive one vehicle to the end of the run; raises BusError."""
    with ZenohBus(VehicleAgent(scenario, vehicle), wiring) as bus:
        bus.run()
