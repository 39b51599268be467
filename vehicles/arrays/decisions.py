"""Decides accelerations and modes from what the vehicles know.

`decision.decide` does the same for one vehicle. It tests for None where this module uses masks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import Motion, Needs, Observation, Output, Relative, Setpoint
from zenvoy.laws.law import SILENT, UNKNOWN
from zenvoy.laws.relative import NAN, Number
from zenvoy.scenarios import Limits
from zenvoy.vehicles.arrays.aims import Aims
from zenvoy.vehicles.arrays.law_calls import LawCalls
from zenvoy.vehicles.arrays.rows import (
    Bools,
    Floats,
    Ints,
    Rows,
    anywhere,
    chosen,
    everywhere,
    within,
)
from zenvoy.vehicles.arrays.view import Known, Reported, Seen, View
from zenvoy.vehicles.control import FOLLOWING
from zenvoy.vehicles.decision import Controller, driven, limited


@dataclass(frozen=True, slots=True, kw_only=True)
class Occasion:
    """A cycle in which all vehicles decide.

    in_force lists the controllers and the vehicles of each. uniform returns random numbers in
    [0, 1) for some vehicles, by number.
    """

    cycle: int
    in_force: Sequence[tuple[Controller, Rows]]
    view: View
    aims: Aims
    uniform: Callable[[Rows, int], Floats]


class Decisions(NamedTuple):
    """The accelerations (m/s²) of every vehicle, within the limits, and the modes behind them.

    neighbours is the number of vehicles that counted on each side. logged has the values that laws
    log, by mode.
    """

    acceleration: Floats
    mode: Ints
    neighbours: Ints
    logged: dict[int, tuple[Floats, ...]]


class Decider:
    """Decides for vehicles within their limits, in runs of vehicles with these names."""

    def __init__(
        self, limits: Sequence[Limits], names: Sequence[str], period_s: float, length_m: float
    ) -> None:
        count = len(limits)
        self._count, self._period_s, self._length_m = count, period_s, length_m
        self._limits = np.array(limits).T
        self._calls = LawCalls(count, names)

    def decide(self, now: Occasion) -> Decisions:
        """Return the decisions of a cycle. Raises LawError or NotCoveredError."""
        a, mode = np.empty(self._count), np.empty(self._count, dtype=np.int64)
        found = Decisions(a, mode, np.zeros(self._count, dtype=np.int64), {})
        for controller, rows in now.in_force:
            self._apply(now, controller, rows, found)
        if now.view.first is not None:
            _cruise(now, now.view.first, found)
        return found._replace(acceleration=limited(found.acceleration, *self._limits))

    def _apply(self, now: Occasion, controller: Controller, rows: Rows, found: Decisions) -> None:
        """Decide for the vehicles of a controller; those that lack data it needs fall back."""
        law, view = controller.law, now.view
        seen = _seen(view, controller)
        follows = None
        ok = _there(seen.ahead.there, rows)
        if view.first is not None:  # the first vehicle cruises, whatever its law
            ok = _both(ok, ~view.first[rows])
        if view.last is not None and law.two_sided():
            follows = view.last[rows] if ok is None else view.last[rows] & ok
            ok = _both(ok, ~view.last[rows])
        ok = _both(ok, _needed(controller, view, seen, rows))
        found.mode[rows] = controller.mode
        if ok is None or anywhere(ok):
            which = rows if ok is None else within(rows, np.flatnonzero(ok))
            self._law(now, controller, which, found)
        if follows is not None and anywhere(follows):
            which = within(rows, np.flatnonzero(follows))
            found.acceleration[which] = _following(seen.ahead.state, seen.speed, now.aims, which)
            ok = follows if ok is None else ok | follows
        if ok is not None and not everywhere(ok):
            which = within(rows, np.flatnonzero(~ok))
            found.mode[which] = pb.MODE_FALLBACK_FM
            found.acceleration[which] = _following(view.radar, view.read.speed, now.aims, which)

    def _law(self, now: Occasion, controller: Controller, rows: Rows, found: Decisions) -> None:
        """Apply a law to vehicles that have all the data it needs."""
        if not controller.law.needs.sides:
            self._call(now, controller, rows, (), found)
            return
        wanted = controller.law.sides(controller.parameters)
        assert now.view.known_sides is not None
        known = np.minimum(now.view.known_sides[rows], wanted)
        found.neighbours[rows] = known
        for count in np.unique(known).tolist():
            some = chosen(known == count)
            assert some is not None
            which = within(rows, some)
            sides = tuple(
                (_relative(ahead, which), _relative(behind, which))
                for ahead, behind in now.view.sides[:count]
            )
            self._call(now, controller, which, sides, found)

    def _call(
        self,
        now: Occasion,
        controller: Controller,
        rows: Rows,
        sides: tuple[tuple[Relative, Relative], ...],
        found: Decisions,
    ) -> None:
        view, needs = now.view, controller.law.needs
        commands = controller.law.hears_commands(controller.parameters)
        seen = _seen(view, controller)
        observation = Observation(
            speed=seen.speed[rows],
            setpoint=_of(now.aims.setpoint, rows),
            ahead=_relative(seen.ahead.state, rows),
            behind=_behind(seen.behind, needs, rows),
            behind_age_s=_behind_age_s(view, needs, rows),
            sides=sides,
            predecessor=_motion(view.predecessor, commands, rows) if needs.predecessor else SILENT,
            leader=_motion(view.leader, commands, rows) if needs.leader else SILENT,
            period_s=self._period_s,
            uniform=lambda number: now.uniform(rows, number),
            acceleration=view.acceleration[rows],
            length_m=self._length_m,
        )
        output = self._calls.call(now.cycle, controller, rows, observation)
        found.acceleration[rows] = output.acceleration
        if output.logged:
            self._log(controller.mode, rows, output, found)

    def _log(self, mode: int, rows: Rows, output: Output, found: Decisions) -> None:
        if mode not in found.logged:
            found.logged[mode] = tuple(np.full(self._count, np.nan) for _ in output.logged)
        for column, values in zip(found.logged[mode], output.logged, strict=True):
            column[rows] = values


def _seen(view: View, controller: Controller) -> Seen:
    """Return the data that a law uses: estimates if it asks for them, or else readings."""
    predicts = controller.law.needs.prediction and view.predicted is not None
    return view.predicted if predicts and view.predicted is not None else view.read


def _cruise(now: Occasion, is_first: Bools, found: Decisions) -> None:
    """Let the first vehicle of an open road keep its speed, unless the schedule gives it one."""
    speed = np.empty(len(is_first))
    for controller, rows in now.in_force:
        speed[rows] = _seen(now.view, controller).speed[rows]
    first = np.flatnonzero(is_first)
    cruise = now.aims.cruise[first]
    towards = driven(speed[first], _of(now.aims.setpoint, first), cruise)
    found.acceleration[first] = np.where(np.isnan(cruise), 0.0, towards)
    found.mode[first] = pb.MODE_CONSTANT_SPEED
    found.neighbours[first] = 0


def _needed(controller: Controller, view: View, seen: Seen, rows: Rows) -> Bools | None:
    """Return where a law has the data it needs, the link ahead aside; None means everywhere."""
    needs = controller.law.needs
    ok = None
    if needs.behind and not (needs.shares_links and needs.tolerates_silence):
        ok = _both(_there(view.read.behind.there, rows), _there(seen.behind.there, rows))
    if needs.sides and view.known_sides is not None:
        ok = _both(ok, view.known_sides[rows] > 0)
    if needs.predecessor and not needs.tolerates_silence:
        ok = _both(ok, _there(view.predecessor.there, rows))
    if needs.leader and not needs.tolerates_silence:
        ok = _both(ok, _there(view.leader.there, rows))
    return None if ok is None or everywhere(ok) else ok


def _there(mask: Bools | None, rows: Rows) -> Bools | None:
    return None if mask is None else mask[rows]


def _both(one: Bools | None, other: Bools | None) -> Bools | None:
    if one is None or other is None:
        return other if one is None else one
    return one & other


def _following(ahead: Relative, speed: Floats, aims: Aims, rows: Rows) -> Floats:
    observation = Observation(speed[rows], _of(aims.setpoint, rows), _relative(ahead, rows))
    followed: Floats = FOLLOWING.law.acceleration(observation, None)
    return followed


def _of(setpoint: Setpoint, rows: Rows) -> Setpoint:
    return Setpoint._make(column[rows] for column in setpoint)


def _relative(state: Relative, rows: Rows) -> Relative:
    return Relative(state.p[rows], state.v[rows])


def _behind(link: Known, needs: Needs, rows: Rows) -> Relative:
    """Return the link behind of some vehicles, if a law needs it; NaN where it is missing."""
    if not needs.behind:
        return UNKNOWN
    state, there = _relative(link.state, rows), _there(link.there, rows)
    if there is None or everywhere(there):
        return state
    return Relative(*(np.where(there, one, np.nan) for one in state))


def _behind_age_s(view: View, needs: Needs, rows: Rows) -> Number:
    if not needs.shares_links or view.behind_age_s is None:
        return NAN
    return view.behind_age_s[rows]


def _motion(report: Reported, commands: bool, rows: Rows) -> Motion:
    """Return what the law of some vehicles gets of a report; NaN where it is missing."""
    motion = report.motion
    if not commands:
        motion = motion._replace(command=SILENT.command)
    there = _there(report.there, rows)
    columns = [one if isinstance(one, float) else one[rows] for one in motion]
    if there is not None and not everywhere(there):
        columns = [np.where(there, one, np.nan) for one in columns]
    return Motion._make(columns)
