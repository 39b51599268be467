"""Runs of one scenario with several seeds, side by side, cycle by cycle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.fleet.arrays.deliveries import Deliveries
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.estimates import Estimates
from zenvoy.vehicles.arrays.rows import Floats
from zenvoy.vehicles.arrays.vehicles import Senses, Vehicles
from zenvoy.world.fleet import Fleet
from zenvoy.world.sensors import SensorSet


class Cycle(NamedTuple):
    """A cycle of all runs. The arrays have an entry for each vehicle of each run, (runs · n,).

    position (m), speed (m/s) and acceleration (mean, m/s²) are the truth at its start. collided
    lists the vehicles that have just run into the vehicle ahead, by run and index. senses,
    decisions and estimates are None after the last cycle, which only moves the truth to the end.
    estimates has the columns of /fleet/estimate. Only a `whole` batch has some of them for every
    vehicle.
    """

    number: int
    position: Floats
    speed: Floats
    acceleration: Floats
    collided: list[tuple[int, int]]
    senses: Senses | None
    decisions: Decisions | None
    estimates: Estimates | None = None


class Batch:
    """Runs of scenarios that differ only in their seed, one cycle after the other.

    A `whole` batch also computes what no vehicle acts on, but a log contains.
    """

    def __init__(self, scenarios: Sequence[Scenario], *, whole: bool = False) -> None:
        first = scenarios[0]
        self.scenarios = tuple(scenarios)
        self._first, self._whole = first, whole
        self._fleet = Fleet(first, scenarios)
        seeds = np.array([one.seed for one in scenarios], dtype=np.uint64)[:, None]
        self._sensors = SensorSet(first.sensors, seeds, first.fleet.size)
        self.vehicles = Vehicles(scenarios)
        settings = [one for scenario in scenarios for one in roster(scenario)]
        self._beaconing = Beaconing(first, settings)
        links = self.vehicles.links_in_use
        behind = self.vehicles.links.behind[0]
        if whole and behind not in links:
            links.append(behind)  # a log has the age of its newest beacon
        self._deliveries = Deliveries(scenarios, links)

    def cycles(self) -> Iterator[Cycle]:
        """Yield every cycle, and then the end. The caller may stop at any time."""
        first, fleet, vehicles = self._first, self._fleet, self.vehicles
        shape = fleet.speed.shape
        period_ns = first.period_ns
        effect_ns = first.v2v_wait_ns + first.system_delay_ns
        for number in range(first.cycles + 1):
            collided = fleet.advance_to(number * period_ns)
            truth = (fleet.position.ravel(), fleet.speed.ravel(), fleet.mean_acceleration.ravel())
            if number == first.cycles:
                yield Cycle(number, *truth, collided, None, None)
                return
            read = self._sensors.read(number, fleet.gaps, fleet.position, fleet.speed)
            senses = Senses(
                position=read.position.ravel(),
                speed=read.speed.ravel(),
                acceleration=truth[2],
                gap=read.gap.ravel(),
                relative_speed=read.relative_speed.ravel(),
            )
            beacons = vehicles.sense(senses)
            self._deliveries.send(number, beacons, *self._beaconing.at(number), truth[0])
            for link, sent, to, which in self._deliveries.due(number):
                vehicles.hear(link, sent, to, which)
            decisions = vehicles.decide(self._whole)
            commands = decisions.acceleration.reshape(shape)
            fleet.command_all(number * period_ns + effect_ns, commands)
            estimates = Estimates(vehicles, decisions)
            yield Cycle(number, *truth, collided, senses, decisions, estimates)
