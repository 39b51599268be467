"""Runs of a variant on Zenvoy's ring: its world, its sensors and its channel, with its seeds."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from examples.neighbourhood.chain import Bools, Floats
from examples.neighbourhood.hosts import Forces, Hosts, Report, Variant
from zenvoy.analysis.measures.metrics import min_distance
from zenvoy.channel.fates import Fates
from zenvoy.scenarios import Scenario, roster
from zenvoy.world.fleet import Fleet
from zenvoy.world.sensors import SensorSet

_END_S: Final = 5.0


class Outcome(NamedTuple):
    """The figures of each run, (runs,), as in a sweep of Zenvoy."""

    gap_error_rms_m: Floats
    min_distance_at_the_end_m: Floats
    smallest_gap_m: Floats
    collisions: Floats
    force_error_mps2: Floats
    """RMS error of the force of the link ahead, as a vehicle acts on it."""
    unbalanced_mps2: Floats
    """RMS difference between the forces with which both ends of a link act on it."""


def run(scenarios: list[Scenario], variant: Variant) -> Outcome:
    """Run scenarios that differ only in their seed.

    A command must take effect after one cycle, as with a delay of 0.1 s.
    """
    first, runs = scenarios[0], len(scenarios)
    period_ns = first.period_ns
    if first.v2v_wait_ns + first.system_delay_ns != period_ns:
        raise ValueError("the delay must be one period")
    fleet, hosts = Fleet(first, scenarios), Hosts(first, variant, runs)
    seeds = np.array([one.seed for one in scenarios], dtype=np.uint64)[:, None]
    sensors = SensorSet(first.sensors, seeds, first.fleet.size)
    channel, figures = _Channel(scenarios, hosts), _Figures(first, runs)
    plan, limits = np.zeros(fleet.speed.size), roster(first)[0].limits
    for cycle in range(first.cycles + 1):
        collided = fleet.advance_to(cycle * period_ns)
        figures.take(cycle, fleet, collided, hosts.forces)
        read = sensors.read(cycle, fleet.gaps, fleet.position, fleet.speed)
        report = Report(
            read.gap.ravel(),
            read.relative_speed.ravel(),
            read.speed.ravel(),
            fleet.mean_acceleration.ravel(),
            plan,
        )
        command = hosts.decide(report, channel.heard(cycle, fleet.position.ravel()))
        fleet.command_all((cycle + 1) * period_ns, command.reshape(fleet.speed.shape))
        plan = np.clip(command, limits.lowest, limits.highest)
    return figures.outcome()


class _Figures:
    """Sums over the cycles of all runs."""

    def __init__(self, scenario: Scenario, runs: int) -> None:
        self._cycles, self._gains = scenario.cycles, scenario.control.gains
        self._last = scenario.cycles - round(_END_S * 1e9) // scenario.period_ns
        self._gap, self._force, self._unbalanced = np.zeros((3, runs))
        self._collisions, self._smallest = np.zeros(runs), np.full(runs, np.inf)
        self._at_end: list[Floats] = []

    def take(
        self, cycle: int, fleet: Fleet, collided: list[tuple[int, int]], forces: Forces
    ) -> None:
        """Take in the truth of a cycle, and the forces that were expected of it."""
        gaps = fleet.gaps
        self._gap += _square(gaps - gaps.mean(axis=1, keepdims=True))
        self._smallest = np.minimum(self._smallest, gaps.min(axis=1))
        for run, _ in collided:
            self._collisions[run] += 1
        if cycle > self._last:
            self._at_end.append(gaps)
        if cycle == 0:
            return
        ahead, behind = (one.reshape(gaps.shape) for one in forces)
        closing = np.roll(fleet.speed, 1, axis=1) - fleet.speed
        self._force += _square(ahead - self._gains.k_d * gaps - self._gains.k_v * closing)
        self._unbalanced += _square(behind - np.roll(ahead, -1, axis=1))

    def outcome(self) -> Outcome:
        """Return the figures of the runs."""
        at_end = np.array(self._at_end)
        ends = [min_distance(at_end[:, run]).mean() for run in range(at_end.shape[1])]
        return Outcome(
            np.sqrt(self._gap / (self._cycles + 1)),
            np.array(ends),
            self._smallest,
            self._collisions,
            np.sqrt(self._force / self._cycles),
            np.sqrt(self._unbalanced / self._cycles),
        )


def _square(values: Floats) -> Floats:
    return np.asarray((values**2).mean(axis=1))


class _Channel:
    """Which vehicles of its chain each host hears."""

    def __init__(self, scenarios: list[Scenario], hosts: Hosts) -> None:
        size, links = hosts.chain.shape
        others = [one for one in range(links) if one != links // 2]
        self._others, self._size = others, size
        source = hosts.chain[:, others].T.ravel()
        self._fates = Fates(tuple(scenarios), source, np.tile(np.arange(size), len(others)))

    def heard(self, cycle: int, position: Floats) -> Bools:
        """Return a mask of the chains, (M, n); every host knows about itself."""
        speaks = np.ones(self._size, dtype=np.bool_)
        sequence = np.full(self._size, cycle)
        heard = self._fates.heard(cycle, speaks, sequence, position) == cycle
        mask = np.ones((self._size, len(self._others) + 1), dtype=np.bool_)
        mask[:, self._others] = (
            np.broadcast_to(heard, self._size * len(self._others)).reshape(len(self._others), -1).T
        )
        return mask
