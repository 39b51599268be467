"""From what the vehicles know to accelerations, and the modes behind them.

As `decision.decide` has it for one vehicle: what is missing there is out of a mask here.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import vehicle_name
from zenvoy.laws import Motion, Observation, Output, Relative, Setpoint, clipped
from zenvoy.laws.errors import LawError, described
from zenvoy.laws.law import SILENT, UNKNOWN
from zenvoy.vehicles.arrays.aims import Aims
from zenvoy.vehicles.arrays.refusal import NotCoveredError
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints, Rows, anywhere, everywhere, within
from zenvoy.vehicles.arrays.strict import strict_arithmetic
from zenvoy.vehicles.control import FOLLOWING
from zenvoy.vehicles.decision import Controller, applied
from zenvoy.vehicles.time_limit import time_limit


class Known(NamedTuple):
    """A state that is not known of everyone; there: of whom it is, None: of all."""

    state: Relative
    there: Bools | None = None


class Reported(NamedTuple):
    """What others report of their motion; there: whose report is fresh, None: everyone's."""

    motion: Motion
    there: Bools | None = None


NOTHING: Final = Reported(SILENT)


class Seen(NamedTuple):
    """What a law decides on: states of both links, and own speed (m/s)."""

    ahead: Known
    behind: Known
    speed: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What there is to decide on, of every vehicle.

    radar: the own one's reading. read: the newest readings. predicted: the estimates at the effect
    of the command, where somebody asks for them. sides: states to the j-th vehicle ahead and
    behind; known_sides: how many of these are known, on both sides. first, last: who stands at the
    ends of an open road.
    """

    radar: Relative
    read: Seen
    predicted: Seen | None = None
    sides: tuple[tuple[Relative, Relative], ...] = ()
    known_sides: Ints | None = None
    predecessor: Reported = NOTHING
    leader: Reported = NOTHING
    first: Bools | None = None
    last: Bools | None = None


class Decisions(NamedTuple):
    """Accelerations (m/s²), within the limit, and the modes behind them, of every vehicle.

    neighbours: how many vehicles on each side counted. logged: what laws log, by mode.
    """

    acceleration: Floats
    mode: Ints
    neighbours: Ints
    logged: dict[int, tuple[Floats, ...]]


class _State(NamedTuple):
    """What a law has left of its decisions, of every vehicle, and in which cycle it did."""

    cycle: Ints
    columns: tuple[Floats, ...]


class Decider:
    """Decides for `count` vehicles, and remembers the states of their laws."""

    def __init__(self, count: int, size: int, limit: float, period_s: float) -> None:
        """`size`: of the fleet of a run; limit: m/s²."""
        self._count, self._size = count, size
        self._limit, self._period_s = limit, period_s
        self._states: dict[int, _State] = {}  # by identity of the controller

    def decide(
        self,
        cycle: int,
        in_force: list[tuple[Controller, Rows]],
        view: View,
        aims: Aims,
        uniform: Callable[[Rows, int, int], Floats],
    ) -> Decisions:
        """Return the decisions of a cycle. `uniform`: random numbers of vehicles, number, cycle."""
        a, mode = np.empty(self._count), np.empty(self._count, dtype=np.int64)
        found = Decisions(a, mode, np.zeros(self._count, dtype=np.int64), {})
        for controller, rows in in_force:
            self._apply(cycle, controller, rows, view, aims, uniform, found)
        if view.first is not None:
            self._cruise(in_force, view, aims, found)
        limited = clipped(found.acceleration, self._limit)
        return found._replace(acceleration=limited)

    def _apply(
        self,
        cycle: int,
        controller: Controller,
        rows: Rows,
        view: View,
        aims: Aims,
        uniform: Callable[[Rows, int, int], Floats],
        found: Decisions,
    ) -> None:
        law = controller.law
        seen = view.read
        if law.needs.prediction and view.predicted is not None:
            seen = view.predicted
        follows = None
        ok = _there(seen.ahead.there, rows)
        if view.first is not None:  # it cruises, whatever its law
            ok = _both(ok, ~view.first[rows])
        if view.last is not None and law.two_sided():
            follows = view.last[rows] if ok is None else view.last[rows] & ok
            ok = _both(ok, ~view.last[rows])
        ok = _both(ok, _needed(controller, view, seen, rows))
        found.mode[rows] = controller.mode
        if ok is None or anywhere(ok):
            self._law(
                cycle,
                controller,
                rows if ok is None else within(rows, np.flatnonzero(ok)),
                seen,
                view,
                aims,
                uniform,
                found,
            )
        if follows is not None and anywhere(follows):
            which = within(rows, np.flatnonzero(follows))
            found.acceleration[which] = _following(seen.ahead.state, seen.speed, aims, which)
            ok = follows if ok is None else ok | follows
        if ok is not None and not everywhere(ok):
            which = within(rows, np.flatnonzero(~ok))
            found.mode[which] = pb.MODE_FALLBACK_FM
            found.acceleration[which] = _following(view.radar, view.read.speed, aims, which)

    def _law(
        self,
        cycle: int,
        controller: Controller,
        rows: Rows,
        seen: Seen,
        view: View,
        aims: Aims,
        uniform: Callable[[Rows, int, int], Floats],
        found: Decisions,
    ) -> None:
        """Apply a law where all that it needs is there."""
        needs = controller.law.needs
        state = self._recalled(cycle, controller, rows)
        observation = Observation(
            seen.speed[rows],
            _of(aims.setpoint, rows),
            _relative(seen.ahead.state, rows),
            _relative(seen.behind.state, rows) if needs.behind else UNKNOWN,
            (),
            Motion._make(x[rows] for x in view.predecessor.motion) if needs.predecessor else SILENT,
            Motion._make(x[rows] for x in view.leader.motion) if needs.leader else SILENT,
            state,
            self._period_s,
            lambda number: uniform(rows, number, cycle),
        )
        if not needs.sides:
            self._take(cycle, controller, rows, observation, found)
            return
        wanted = controller.law.sides(controller.parameters)
        assert view.known_sides is not None
        known = np.minimum(view.known_sides[rows], wanted)
        found.neighbours[rows] = known
        for count in np.unique(known).tolist():
            some = slice(None) if (known == count).all() else np.flatnonzero(known == count)
            which = within(rows, some)
            sides = tuple(
                (_relative(ahead, which), _relative(behind, which))
                for ahead, behind in view.sides[:count]
            )
            of_some = _part(observation, some)._replace(sides=sides)
            self._take(cycle, controller, which, of_some, found)

    def _take(
        self,
        cycle: int,
        controller: Controller,
        rows: Rows,
        observation: Observation,
        found: Decisions,
    ) -> None:
        output = self._output(controller, rows, observation)
        found.acceleration[rows] = output.acceleration
        if output.state:
            self._keep(cycle, controller, rows, output.state)
        if output.logged:
            columns = found.logged.setdefault(
                controller.mode, tuple(np.full(self._count, np.nan) for _ in output.logged)
            )
            for column, values in zip(columns, output.logged, strict=True):
                column[rows] = values

    def _output(self, controller: Controller, rows: Rows, observation: Observation) -> Output:
        """What the law returns.

        Raises LawError with the name of the vehicle, as for one alone; NotCoveredError where it
        fails for all at once, and not for each of them.
        """
        law, limit_s = controller.law, controller.limit_s
        strict = nullcontext() if limit_s is None else strict_arithmetic()
        try:
            with time_limit(limit_s), strict:
                returned = law.acceleration(observation, controller.parameters)
            output = returned if isinstance(returned, Output) else Output(returned)
            if _usable(output, len(law.columns)):
                return output
        except BaseException as error:  # whatever it raises is its own, also sys.exit
            self._blame(controller, rows, observation)
            what = " ".join(described(error).split())
            raise NotCoveredError(f"law {law.name} raised {what}, but only on arrays") from error
        self._blame(controller, rows, observation)
        raise NotCoveredError(f"law {law.name} gives other values on arrays than on floats")

    def _blame(self, controller: Controller, rows: Rows, observation: Observation) -> None:
        """Raise LawError for the first vehicle on which the law fails."""
        for at, member in enumerate(np.arange(self._count)[rows].tolist()):
            try:
                applied(controller, _alone(observation, at))
            except LawError as error:
                error.process = vehicle_name(member % self._size + 1, self._size)
                raise

    def _recalled(self, cycle: int, controller: Controller, rows: Rows) -> tuple[Floats, ...]:
        """The states of the law; those that it starts with, where it did not decide just now."""
        initial = controller.law.state
        if not initial:
            return ()
        start = tuple(np.full(self._count, value) for value in initial)
        kept = self._states.get(id(controller))
        if kept is None:
            return tuple(column[rows] for column in start)
        goes_on = kept.cycle == cycle - 1
        return tuple(
            np.where(goes_on, value, first)[rows]
            for value, first in zip(kept.columns, start, strict=True)
        )

    def _keep(
        self, cycle: int, controller: Controller, rows: Rows, state: tuple[Floats, ...]
    ) -> None:
        kept = self._states.get(id(controller))
        if kept is None:
            never = np.full(self._count, -2, dtype=np.int64)
            kept = _State(never, tuple(np.zeros(self._count) for _ in state))
            self._states[id(controller)] = kept
        kept.cycle[rows] = cycle
        for column, values in zip(kept.columns, state, strict=True):
            column[rows] = values

    def _cruise(
        self, in_force: list[tuple[Controller, Rows]], view: View, aims: Aims, found: Decisions
    ) -> None:
        """The first of an open road keeps its speed, unless the schedule gives it one."""
        assert view.first is not None
        speed = view.read.speed
        if view.predicted is not None:
            speed = speed.copy()
            for controller, rows in in_force:
                if controller.law.needs.prediction:
                    speed[rows] = view.predicted.speed[rows]
        first = np.flatnonzero(view.first)
        setpoint = _of(aims.setpoint, first)
        cruise = aims.cruise[first]
        driven = cruise + setpoint.k_c * (setpoint.v_des - speed[first])
        found.acceleration[first] = np.where(np.isnan(cruise), 0.0, driven)
        found.mode[first] = pb.MODE_CONSTANT_SPEED
        found.neighbours[first] = 0


def _needed(controller: Controller, view: View, seen: Seen, rows: Rows) -> Bools | None:
    """Where all is there that the law needs beside the link ahead; None: everywhere."""
    needs = controller.law.needs
    ok = None
    if needs.behind:
        ok = _both(_there(view.read.behind.there, rows), _there(seen.behind.there, rows))
    if needs.sides and view.known_sides is not None:
        ok = _both(ok, view.known_sides[rows] > 0)
    if needs.predecessor:
        ok = _both(ok, _there(view.predecessor.there, rows))
    if needs.leader:
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


def _part(observation: Observation, some: Rows) -> Observation:
    """What some of the vehicles of an observation see."""
    if isinstance(some, slice):
        return observation
    return observation._replace(
        speed=observation.speed[some],
        setpoint=_of(observation.setpoint, some),
        ahead=_relative(observation.ahead, some),
        behind=UNKNOWN if observation.behind is UNKNOWN else _relative(observation.behind, some),
        predecessor=SILENT
        if observation.predecessor is SILENT
        else Motion._make(x[some] for x in observation.predecessor),
        leader=SILENT
        if observation.leader is SILENT
        else Motion._make(x[some] for x in observation.leader),
        state=tuple(value[some] for value in observation.state),
    )


def _usable(output: Output, columns: int) -> bool:
    """Whether a law has returned what `decision.applied` asks for, for every vehicle."""
    numbers = (output.acceleration, *output.state)
    return (
        all(everywhere(np.isfinite(values)) for values in numbers)
        and len(output.logged) == columns
        and not any(anywhere(np.isinf(values)) for values in output.logged)
    )


def _alone(observation: Observation, at: int) -> Observation:
    """What one vehicle sees, in floats."""

    def one(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return float(value[at])
        if isinstance(value, tuple):
            parts = [one(part) for part in value]
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        return value

    def uniform(number: int) -> float:
        return float(observation.uniform(number)[at])

    seen: Observation = one(observation)
    return seen._replace(uniform=uniform)
