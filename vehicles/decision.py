"""From what a vehicle knows to an acceleration and the mode behind it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from math import isfinite, isinf
from typing import Any, Final, NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.laws import (
    Law,
    Motion,
    Needs,
    Observation,
    Output,
    Relative,
    Setpoint,
    larger,
    law_of,
    smaller,
)
from zenvoy.laws.errors import raised, useless
from zenvoy.laws.law import SILENT
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Limits
from zenvoy.vehicles.steps import Number
from zenvoy.vehicles.time_limit import time_limit

_FOLLOWING: Final = law_of("FM").acceleration


class Position(Enum):
    """Where a vehicle stands in the fleet; on the ring everyone is in the middle."""

    FIRST = auto()
    MIDDLE = auto()
    LAST = auto()


class View(NamedTuple):
    """What there is to decide on; None (or nothing) where it is missing or too old.

    radar: the own one's reading; ahead, behind: states of both links, by radar or by positions;
    speed: the own one, m/s. sides: the states to the j-th vehicle ahead and behind, j = 1..m, as
    far as the chain reaches on both sides. predecessor, leader: what the vehicle ahead and the
    leader of the platoon report of themselves. acceleration: the own one, m/s². length_m: of every
    vehicle, m.
    """

    radar: Relative | None
    ahead: Relative | None
    behind: Relative | None
    speed: float
    sides: tuple[tuple[Relative, Relative], ...] = ()
    predecessor: Motion | None = None
    leader: Motion | None = None
    acceleration: float = NAN
    length_m: float = NAN


class Predicted(NamedTuple):
    """States of both links and own speed (m/s) at the instant the command takes effect."""

    ahead: Relative | None
    behind: Relative | None
    speed: float


class Aim(NamedTuple):
    """What a vehicle is to reach, and within which accelerations (m/s²).

    cruise: how fast (m/s²) the desired speed of one who has nobody ahead changes; None: it keeps
    its speed.
    """

    setpoint: Setpoint
    limits: Limits
    cruise: float | None = None


@dataclass(frozen=True, slots=True)
class Controller:
    """A law with its parameters, and the number that stands for it in the log.

    limit_s: wall time that a decision may take; None for a law of the library.
    """

    law: Law
    parameters: Any
    mode: int
    limit_s: float | None = None


class Decision(NamedTuple):
    """Acceleration (m/s²), within the limits, and the mode behind it.

    neighbours: how many vehicles on each side counted (0: the law looks at none). logged, state:
    what the law returned beside the acceleration.
    """

    acceleration: float
    mode: int
    neighbours: int = 0
    logged: tuple[float, ...] = ()
    state: tuple[float, ...] | None = None


def decide(
    controller: Controller,
    position: Position,
    read: View,
    predicted: Predicted | None,
    aim: Aim,
    state: tuple[float, ...] | None = None,
    period_s: float = 0.0,
    uniform: Callable[[int], float] = lambda _: 0.0,
) -> Decision:
    """Acceleration for a vehicle under a controller. Raises LawError.

    Where what the law needs of others is missing, the vehicle falls back to FM on its own radar.
    The ends of the open road follow paper Eq. 5: the first keeps its speed unless the schedule
    gives it one, the last has nobody behind and follows. `state` is what the law's last decision
    left, None where it takes over.
    """
    law = controller.law
    seen = predicted if predicted is not None and law.needs.prediction else read
    if position is Position.FIRST:
        return Decision(limited(cruising(seen.speed, aim), *aim.limits), pb.MODE_CONSTANT_SPEED)
    if read.radar is None:
        return Decision(0.0, pb.MODE_CONSTANT_SPEED)
    if seen.ahead is not None and position is Position.LAST and law.two_sided():
        return _follow(seen.ahead, seen.speed, aim, controller.mode)
    observation = _observed(law, position, read, seen, aim.setpoint)
    if observation is None:
        return _follow(read.radar, read.speed, aim, pb.MODE_FALLBACK_FM)
    observation = observation._replace(
        state=law.state if state is None else state,
        period_s=period_s,
        uniform=uniform,
        acceleration=read.acceleration,
        length_m=read.length_m,
    )
    output = applied(controller, observation)
    return Decision(
        limited(output.acceleration, *aim.limits),
        controller.mode,
        len(observation.sides),
        output.logged,
        output.state,
    )


def limited(a: Number, lowest: Number, highest: Number) -> Number:
    """Return the acceleration that a vehicle may command, m/s²: floats or arrays."""
    return larger(lowest, smaller(highest, a))


def cruising(v: float, aim: Aim) -> float:
    """Acceleration of a vehicle with nobody ahead, m/s².

    0, as the paper's Eq. 5 has it; or, once it has been given a desired speed, what is left of
    FM, with the rate of that speed fed forward, so that a ramp is followed whatever k_c is.
    """
    return 0.0 if aim.cruise is None else driven(v, aim.setpoint, aim.cruise)


def driven(v: Number, setpoint: Setpoint, cruise: Number) -> Number:
    """Acceleration towards the desired speed, which changes by `cruise`, m/s²: floats or arrays."""
    return cruise + setpoint.k_c * (setpoint.v_des - v)


def _follow(ahead: Relative, speed: float, aim: Aim, mode: int) -> Decision:
    acceleration = _FOLLOWING(Observation(speed, aim.setpoint, ahead), None)
    return Decision(limited(acceleration, *aim.limits), mode)


def _observed(
    law: Law, position: Position, read: View, seen: View | Predicted, setpoint: Setpoint
) -> Observation | None:
    """What the law is given to decide on; None where something that it needs is missing."""
    needs = law.needs
    if seen.ahead is None or (position is Position.LAST and law.two_sided()):
        return None
    observation = Observation(seen.speed, setpoint, seen.ahead)
    if needs.behind:
        if read.behind is None or seen.behind is None:
            return None
        observation = observation._replace(behind=seen.behind)
    if needs.sides:
        if not read.sides:
            return None
        observation = observation._replace(sides=read.sides)
    if needs.predecessor or needs.leader:
        return _with_reports(observation, needs, read)
    return observation


def _with_reports(observation: Observation, needs: Needs, read: View) -> Observation | None:
    predecessor = read.predecessor if needs.predecessor else SILENT
    leader = read.leader if needs.leader else SILENT
    if (predecessor is None or leader is None) and not needs.tolerates_silence:
        return None
    return observation._replace(predecessor=predecessor or SILENT, leader=leader or SILENT)


def applied(controller: Controller, observation: Observation) -> Output:
    """Return what the law returns, checked. Raises LawError."""
    law = controller.law
    try:
        with time_limit(controller.limit_s):
            returned = law.acceleration(observation, controller.parameters)
    except BaseException as error:  # whatever it raises is its own, also sys.exit
        raise raised(f"law {law.name}", law.acceleration, error) from error
    output = returned if isinstance(returned, Output) else Output(returned)
    try:
        is_number = isfinite(output.acceleration) and all(map(isfinite, output.state))
        has_columns = len(output.logged) == len(law.columns) and not any(map(isinf, output.logged))
    except TypeError:
        is_number = has_columns = False
    if not is_number:
        text = f"returned {output.acceleration!r}, which is no acceleration"
        raise useless(f"law {law.name}", law.acceleration, text)
    if not has_columns:
        text = f"returned {output.logged!r} to be logged, not {len(law.columns)} numbers"
        raise useless(f"law {law.name}", law.acceleration, text)
    return output
