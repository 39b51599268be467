"""The agents of a run: world, channel, and one for each vehicle."""

from __future__ import annotations

from zenvoy.bus.agent import Agent
from zenvoy.channel.lock_step import LockStepChannel
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.lock_step import LockStepVehicle
from zenvoy.world.lock_step import LockStepWorld


def agents_of(scenario: Scenario) -> list[Agent]:
    """Return the agents of a run in lock-step, vehicle v at index v + 1."""
    vehicles = range(1, scenario.fleet.size + 1)
    return [
        LockStepWorld(scenario),
        LockStepChannel(scenario),
        *(LockStepVehicle(scenario, vehicle) for vehicle in vehicles),
    ]
