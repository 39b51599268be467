"""Runs of one scenario side by side, cycle by cycle, for as many seeds as are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.fleet.arrays.deliveries import Deliveries
from zenvoy.fleet.arrays.estimates import Estimates
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import Beaconing
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.vehicles import Readings, Vehicles
from zenvoy.world.fleet import Fleet
from zenvoy.world.sensors import SensorSet

Floats = NDArray[np.float64]


class Cycle(NamedTuple):
    """What a cycle was, of all runs; everything but `collided` is an array (runs · n,).

    truth: position (m), speed (m/s), mean acceleration (m/s²) at its start. collided: run and
    index of those who have just run into the vehicle ahead. readings and decisions are None after
    the last cycle, which only moves the truth to the end. estimates: columns of /fleet/estimate, of
    which some are those of every vehicle in a `whole` batch only.
    """

    number: int
    position: Floats
    speed: Floats
    acceleration: Floats
    collided: list[tuple[int, int]]
    readings: Readings | None
    decisions: Decisions | None
    estimates: Estimates | None = None


class Batch:
    """Scenarios that differ in nothing but their seed. `whole`: everything that a log tells."""

    def __init__(self, scenarios: Sequence[Scenario], *, whole: bool = False) -> None:
        first = scenarios[0]
        self.scenarios = tuple(scenarios)
        self._first, self._whole = first, whole
        self._fleet = Fleet(first, len(scenarios))
        seeds = np.array([one.seed for one in scenarios], dtype=np.uint64)[:, None]
        self._sensors = SensorSet(first.sensors, seeds, first.fleet.size)
        self.vehicles = Vehicles(scenarios)
        settings = [one for scenario in scenarios for one in roster(scenario)]
        self._beaconing = Beaconing(first, settings)
        links = self.vehicles.links_in_use
        behind = self.vehicles.links.behind[0]
        if whole and behind not in links:
            links.append(behind)  # a log tells the age of what came on it
        self._deliveries = Deliveries(scenarios, links)

    def cycles(self) -> Iterator[Cycle]:
        """Yield every cycle, and at last the end. The caller may stop at any time."""
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
            readings = Readings(
                position=read.position.ravel(),
                speed=read.speed.ravel(),
                acceleration=truth[2],
                gap=read.gap.ravel(),
                relative_speed=read.relative_speed.ravel(),
            )
            beacons = vehicles.sense(readings)
            self._deliveries.send(number, beacons, *self._beaconing.at(number), truth[0])
            for link, sent, to, which in self._deliveries.due(number):
                vehicles.hear(link, sent, to, which)
            decisions = vehicles.decide(self._whole)
            commands = decisions.acceleration.reshape(shape)
            fleet.command_all(number * period_ns + effect_ns, commands)
            estimates = Estimates(vehicles, decisions)
            yield Cycle(number, *truth, collided, readings, decisions, estimates)
