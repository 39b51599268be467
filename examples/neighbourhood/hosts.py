"""All vehicles of many runs, each with a filter of its own chain of links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from examples.neighbourhood.chain import Bools, Filters, Floats, Model
from zenvoy.laws import Observation, Relative, Setpoint
from zenvoy.laws.library.bcm import bilateral
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.link_errors import nominal_variances


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """What a vehicle estimates and how it decides.

    reach: links each way in its state. coupled: one filter for all of them, or one for each.
    holds: whether an unheard vehicle is expected to go on accelerating as it last did, or to keep
    its speed.
    acceleration_std: noise of a link between vehicles whose acceleration is heard, m/s²;
    unheard_std: more noise for each vehicle that is not heard, m/s². shared: whether both ends of a
    link act on the estimate of the vehicle at its rear. speeds: whether a chain also takes in the
    speeds that other vehicles report.
    """

    reach: int = 1
    coupled: bool = True
    holds: bool = False
    acceleration_std: float = 0.5
    unheard_std: float = 0.0
    shared: bool = False
    speeds: bool = False


class Report(NamedTuple):
    """What all vehicles report in a cycle, (M,): m, m/s and m/s².

    a: the mean acceleration since the last cycle. plan: the one until the next cycle.
    """

    gap: Floats
    relative_speed: Floats
    speed: Floats
    a: Floats
    plan: Floats


class Forces(NamedTuple):
    """The forces k_d p + k_v v of the links ahead and behind when commands take effect, m/s²."""

    ahead: Floats
    behind: Floats


class Hosts:
    """The M vehicles of runs on a ring, one run after the other. Call `decide` in each cycle."""

    def __init__(self, scenario: Scenario, variant: Variant, runs: int) -> None:
        control, size = scenario.control, scenario.fleet.size
        self._variant = variant
        self._period_s = scenario.period_ns * 1e-9
        self._gap_variance, self._speed_variance = nominal_variances(scenario)
        gains = control.gains
        self._setpoint = Setpoint(
            gains.k_d, gains.k_v, gains.k_c, control.desired_gap_m, control.desired_speed_mps
        )
        m = variant.reach
        number = np.arange(size)[:, None] + np.arange(-m, m + 1)
        self.chain = (number % size + size * np.arange(runs)[:, None, None]).reshape(-1, 2 * m + 1)
        """The vehicles of each host's chain, front to back, (M, n)."""
        hosts = len(self.chain)
        self._model = Model.of(m, self._period_s, coupled=variant.coupled)
        start = np.zeros(4 * m + 1)
        start[: 2 * m], start[-1] = control.desired_gap_m, control.desired_speed_mps
        self._filters = Filters(self._model, start, 1e3, hosts)
        self._expected = np.zeros(self.chain.shape)  # accelerations until the next cycle, m/s²
        self._planned = np.ones(self.chain.shape, dtype=np.bool_)  # whether they are plans
        self._behind = Relative(*np.tile(start[[m, 3 * m]], (hosts, 1)).T)
        self.forces = Forces(np.zeros(hosts), np.zeros(hosts))
        """What the newest commands are made of."""

    def decide(self, report: Report, heard: Bools) -> Floats:
        """Return the commands of a cycle, m/s², (M,). heard: which of the chain are, (M, n)."""
        variant, m = self._variant, self._variant.reach
        a = np.where(heard, report.a[self.chain], self._expected)
        known = heard | self._planned
        noise = 0.5 * variant.acceleration_std**2 + np.where(known, 0.0, variant.unheard_std**2)
        carried = self._filters.x[self.chain[:, m + 1]]  # by the beacons of the vehicles behind
        self._filters.predict(a, noise)
        before = self._filters.x
        self._take_in(report, heard)

        silent = self._expected if variant.holds else 0.0
        plan = np.where(heard, report.plan[self.chain], silent)
        self._expected, self._planned = plan, heard
        there = self._model.after(self._filters.x, plan)
        ahead, behind = self._link(there, m - 1), self._link(there, m)
        if variant.shared:
            ahead = self._link(self._model.after(before, plan), m - 1)
            behind = self._shared(self._link(carried, m - 1), a, plan, heard[:, m + 1])
        self.forces = Forces(self._force(ahead), self._force(behind))
        return np.asarray(bilateral(Observation(there[:, -1], self._setpoint, ahead, behind)))

    def _link(self, x: Floats, link: int) -> Relative:
        return Relative(x[:, link], x[:, self._model.links + link])

    def _force(self, link: Relative) -> Floats:
        return np.asarray(self._setpoint.k_d * link.p + self._setpoint.k_v * link.v)

    def _take_in(self, report: Report, heard: Bools) -> None:
        """Take in the readings of all that are heard."""
        filters, model, host = self._filters, self._model, self._variant.reach
        for link in range(model.links):
            rear, of = self.chain[:, link + 1], heard[:, link + 1]
            filters.read(model.gap(link), report.gap[rear], self._gap_variance, of)
            z = report.relative_speed[rear]
            filters.read(model.relative_speed(link), z, self._speed_variance, of)
        for vehicle in range(model.links + 1) if self._variant.speeds else [host]:
            z = report.speed[self.chain[:, vehicle]]
            filters.read(model.speed(vehicle), z, self._speed_variance, heard[:, vehicle])

    def _shared(self, carried: Relative, a: Floats, plan: Floats, heard: Bools) -> Relative:
        """Return the link behind when the command takes effect, by its rear vehicle's estimate.

        A beacon carries the estimate of the cycle before. Both ends bring it up to date with the
        accelerations that they know.
        """
        m, period_s = self._variant.reach, self._period_s
        p, v = (
            np.where(heard, np.asarray(new), old)
            for new, old in zip(carried, self._behind, strict=True)
        )
        for acting in (a, plan):
            relative = acting[:, m] - acting[:, m + 1]
            p = p + period_s * (v + 0.5 * period_s * relative)
            v = v + period_s * relative
            if acting is a:
                self._behind = Relative(p, v)
        return Relative(p, v)
