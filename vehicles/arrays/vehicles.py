"""The vehicles of many runs, cycle by cycle: they send beacons, receive frames and decide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.bus.topics import vehicle_name
from zenvoy.keyed_random.draws import Purpose, uniforms
from zenvoy.laws import Relative
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.aims import Schedule
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.control import Controllers
from zenvoy.vehicles.arrays.decisions import Decider, Decisions, Occasion
from zenvoy.vehicles.arrays.estimation import Estimation, Roles
from zenvoy.vehicles.arrays.links import (
    by_position,
    by_radar,
    links_of,
    radar_of,
    reported,
)
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.plans import Plan
from zenvoy.vehicles.arrays.rows import ALL, Bools, Floats, Ints, Rows, chosen
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.view import NOTHING, Known, Reported, Seen, View
from zenvoy.vehicles.control import reports_commands


class Senses(NamedTuple):
    """The sensor readings of all vehicles at the start of a cycle, as in `pb.Sense`.

    Units are m, m/s and m/s². The gap is NaN for a vehicle without a vehicle ahead.
    """

    position: Floats
    speed: Floats
    acceleration: Floats
    gap: Floats
    relative_speed: Floats


class Vehicles:
    """The vehicles of runs that differ only in their seed.

    In each cycle, call `sense`, then `hear` for each link and each cycle whose beacons have
    arrived, the oldest first, then `decide`.

    These are all vehicles of the fleet, unless `members` names those of a process. The beacons of
    members go to processes that may need all that they contain.
    """

    def __init__(self, scenarios: Sequence[Scenario], members: Sequence[int] | None = None) -> None:
        first = scenarios[0]
        size, runs = first.fleet.size, len(scenarios)
        there = members or range(1, size + 1)
        self.timing = Timing.of(first)
        self._by_position = first.control.neighbour_state == "position"
        settings = [roster(scenario)[one - 1] for scenario in scenarios for one in there]
        number = np.tile(np.array(there) - 1, runs)
        steps = number % (first.control.platoon.size or size)
        self._steps_to_leader = steps.astype(np.float64)
        self._controllers = Controllers(first, settings, leads=steps == 0)
        every = self._controllers.every
        needs = [one.law.needs for one in every]
        self.links = links_of(first, self.timing, every, runs, there)
        self._m = max(one.law.sides(one.parameters) for one in every)
        self._looks_behind = any(one.behind for one in needs)
        self._wants_motion = members is not None or any(
            one.predecessor or one.leader for one in needs
        )
        # Shares of a fleet are drawn by seed, so a law may drive in some of the runs only.
        self._reports_commands = any(one.law.hears_commands(one.parameters) for one in every)
        if members is not None:
            self._reports_commands = reports_commands(first)  # others may need them
        self._wants_predecessor = any(one.predecessor for one in needs)
        self._schedule = Schedule(settings)
        limits = [one.limits for one in settings]
        names = [vehicle_name(one, size) for one in there]
        self._decider = Decider(limits, names, first.period_ns * 1e-9, first.fleet.length_m)
        self._vehicle = number + 1
        seeds = np.array([one.seed for one in scenarios], dtype=np.uint64)
        self._seed = np.repeat(seeds, len(there))
        self._first: Bools | None = None
        self._last: Bools | None = None
        self._radar: Rows = ALL
        if first.ring_length_m is None:
            self._first, self._last = number == 0, number == size - 1
            self._radar = np.flatnonzero(~self._first)
        predicts = any(one.prediction for one in needs)
        lag_s = np.array([one.lag_s for one in settings])
        plans = predicts or members is not None
        self.own = OwnMotion(self.timing, lag_s, predicts=plans)
        self.estimation: Estimation | None = None
        """Estimates and predictions, if any law needs them."""
        if predicts:
            roles = Roles.of(settings)
            self.estimation = Estimation(first, self.timing, self.own, self.links, roles)
        self._beacons: Beacons | None = None
        self.cycle = -1

    @property
    def links_in_use(self) -> list[Link]:
        """The links whose beacons a controller uses."""
        ahead, behind = self._m, self._m
        if not self._by_position and ahead:
            ahead -= 1  # the own radar measures the first link
        if self.estimation is not None or self._wants_predecessor or self._by_position:
            ahead = max(ahead, 1)
        if self.estimation is not None or self._looks_behind:
            behind = max(behind, 1)
        leader = [] if self.links.leader is None else [self.links.leader]
        return [*self.links.ahead[:ahead], *self.links.behind[:behind], *leader]

    def sense(self, senses: Senses) -> Beacons:
        """Begin the next cycle with these readings, and return the beacons of the vehicles."""
        self.cycle += 1
        plan = Plan(())
        if self.estimation is not None or self._wants_motion:
            plan = self.own.sense(senses.acceleration)
        command = self.own.newest_command if self._reports_commands else None
        self._beacons = Beacons(*senses, plan, command)
        if self.estimation is not None:
            self._beacons = self.estimation.sense(self.cycle, self._beacons)
        return self._beacons

    def hear(self, link: Link, cycle: int, to: Bools | None, beacons: Beacons) -> None:
        """Store beacons of a cycle that a link has delivered.

        to is a mask of the receivers; None means every vehicle that the link reaches.
        """
        rows: Rows | None = ALL if to is None and link.reaches_all else None
        if rows is None:
            news = link.exists & (link.cycle < cycle)
            rows = chosen(news if to is None else news & to)
        if rows is None:
            return
        if self.estimation is None:
            link.hear(cycle, rows, beacons)
        else:
            self.estimation.hear(link, cycle, self.cycle, rows, beacons)

    def decide(self, wants_all: bool) -> Decisions:
        """Return the decisions of the cycle.

        With `wants_all`, links are also estimated where no vehicle acts on them.
        """
        decisions = self._decided(wants_all)
        self._command(decisions.acceleration)
        return decisions

    def pass_by(self) -> None:
        """End the cycle without new commands, in real time: the newest ones stay in force."""
        self._decided(wants_all=True)  # the filters go on
        self._command(self.own.newest_command)

    def _command(self, acceleration: Floats) -> None:
        if self.estimation is not None or self._wants_motion:
            self.own.command(acceleration)

    def _decided(self, wants_all: bool) -> Decisions:
        beacons, cycle = self._beacons, self.cycle
        assert beacons is not None
        now_ns = cycle * self.timing.period_ns + self.timing.wait_ns
        return self._decider.decide(
            Occasion(
                cycle=cycle,
                in_force=self._controllers.at(now_ns),
                view=self._view(beacons, wants_all),
                aims=self._schedule.at(now_ns),
                uniform=self._uniform,
            )
        )

    def _view(self, beacons: Beacons, wants_all: bool) -> View:
        links, cycle, behind = self.links, self.cycle, self.links.behind[0]
        radar = Relative(beacons.gap, beacons.relative_speed)
        sides: tuple[tuple[Relative, Relative], ...] = ()
        known_sides: Ints | None = None
        if self._by_position:
            here = beacons.position + beacons.speed * self.timing.wait_ns * 1e-9
            states = by_position(links, here, beacons.speed, cycle)
            read = Seen(states.ahead[0], states.behind[0], beacons.speed)
        else:
            read = Seen(Known(radar), radar_of(behind, cycle), beacons.speed)
            states = None
        if self._m:
            states = by_radar(links, radar, cycle) if states is None else states
            sides, known_sides = states.pairs, states.known
        predicted, shared = None, None
        if self.estimation is not None:
            wanted = None if wants_all else read.behind.there
            predicted = self.estimation.estimate(cycle, beacons, self._radar, wanted)
            shared = self.estimation.shared
        return View(
            radar=radar,
            read=read,
            predicted=predicted,
            sides=sides,
            known_sides=known_sides,
            predecessor=self._predecessor(beacons.position),
            leader=self._leader(beacons.position),
            acceleration=beacons.acceleration,
            behind_age_s=None if shared is None else shared.behind_age_s(cycle),
            first=self._first,
            last=self._last,
        )

    def _predecessor(self, here: Floats) -> Reported:
        """Return the reports of the vehicles ahead; here: the own positions, m."""
        if not self._wants_predecessor:
            return NOTHING
        return reported(self.links.ahead[0], self.cycle, here - self.links.seam_ahead[0], 1.0)

    def _leader(self, here: Floats) -> Reported:
        """Return the reports of the leaders, which have lower numbers: no seam lies between."""
        leader = self.links.leader
        if leader is None:
            return NOTHING
        return reported(leader, self.cycle, here, self._steps_to_leader)

    def _uniform(self, rows: Rows, number: int) -> Floats:
        """Return the random numbers in [0, 1) that vehicles draw for their laws in this cycle."""
        keys = (self._vehicle[rows], number, self.cycle)
        return uniforms(self._seed[rows], Purpose.LAW, *keys)[0]
