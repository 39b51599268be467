"""Decides an acceleration, and the mode behind it, from what a vehicle knows."""

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
from zenvoy.laws.law import SILENT, UNKNOWN
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Limits
from zenvoy.vehicles.invalid_output import why_invalid
from zenvoy.vehicles.steps import Number
from zenvoy.vehicles.time_limit import time_limit

_FOLLOWING: Final = law_of("FM").acceleration


class Position(Enum):
    """The place of a vehicle in the fleet; on a ring every vehicle is in the middle."""

    FIRST = auto()
    MIDDLE = auto()
    LAST = auto()


class View(NamedTuple):
    """The data to decide on; None (or empty) if they are missing or too old.

    radar: the reading of the own radar. ahead, behind: states of both links, by radar or by
    positions. speed: own speed, m/s. sides: the states to the j-th vehicle ahead and behind,
    j = 1..m, as far as the chain reaches on both sides. predecessor, leader: what the vehicle ahead
    and the leader of the platoon report about themselves. acceleration: own acceleration, m/s².
    length_m: length of every vehicle, m. behind_age_s: age of what is
    known of a shared link behind, s; NaN if nothing is.
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
    behind_age_s: float = NAN


class Predicted(NamedTuple):
    """States of both links and own speed (m/s) when the command takes effect."""

    ahead: Relative | None
    behind: Relative | None
    speed: float


class Aim(NamedTuple):
    """The setpoint of a vehicle, and its limits of acceleration (m/s²).

    cruise: the rate (m/s²) at which the desired speed changes, for a vehicle with nobody ahead;
    None: it keeps its speed.
    """

    setpoint: Setpoint
    limits: Limits
    cruise: float | None = None


@dataclass(frozen=True, slots=True)
class Controller:
    """A law with its parameters, and its number in the log.

    limit_s: the wall time that a decision may take; None for a law of the library.
    """

    law: Law
    parameters: Any
    mode: int
    limit_s: float | None = None


class Decision(NamedTuple):
    """An acceleration (m/s²), within the limits, and the mode behind it.

    neighbours: how many vehicles on each side counted (0: the law uses none). logged, state: what
    the law returned besides the acceleration.
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
    """Return the decision of a vehicle under a controller; raises LawError.

    If data that the law needs from others are missing, the vehicle falls back to FM on its own
    radar. The ends of an open road follow paper Eq. 5: the first vehicle keeps its speed unless the
    schedule gives it one, and the last vehicle, which has nobody behind, runs FM. `state` is the
    state that the law returned last, or None if it has just taken over.
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
    """Return the acceleration within the limits, m/s²; floats or arrays."""
    return larger(lowest, smaller(highest, a))


def cruising(v: float, aim: Aim) -> float:
    """Return the acceleration of a vehicle with nobody ahead, m/s².

    It is 0, as in the paper's Eq. 5, until the schedule gives the vehicle a desired speed. From
    then on it is the last term of FM, plus the rate of the desired speed as a feedforward, so that
    the vehicle follows a ramp for any k_c.
    """
    return 0.0 if aim.cruise is None else driven(v, aim.setpoint, aim.cruise)


def driven(v: Number, setpoint: Setpoint, cruise: Number) -> Number:
    """Return the acceleration towards a desired speed that changes at the rate `cruise`, m/s².

    It takes floats or arrays.
    """
    return cruise + setpoint.k_c * (setpoint.v_des - v)


def _follow(ahead: Relative, speed: float, aim: Aim, mode: int) -> Decision:
    acceleration = _FOLLOWING(Observation(speed, aim.setpoint, ahead), None)
    return Decision(limited(acceleration, *aim.limits), mode)


def _observed(
    law: Law, position: Position, read: View, seen: View | Predicted, setpoint: Setpoint
) -> Observation | None:
    """Return the observation for a law; None if something that it needs is missing."""
    needs = law.needs
    if seen.ahead is None or (position is Position.LAST and law.two_sided()):
        return None
    observation = Observation(seen.speed, setpoint, seen.ahead)
    if needs.behind:
        missing = read.behind is None or seen.behind is None
        if missing and not (needs.shares_links and needs.tolerates_silence):
            return None
        observation = observation._replace(behind=seen.behind or UNKNOWN)
    if needs.shares_links:
        observation = observation._replace(behind_age_s=read.behind_age_s)
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
    """Return the checked output of the law; raises LawError."""
    law = controller.law
    try:
        with time_limit(controller.limit_s):
            returned = law.acceleration(observation, controller.parameters)
    except BaseException as error:  # the law may raise anything, even by sys.exit
        raise raised(f"law {law.name}", law.acceleration, error) from error
    output = returned if isinstance(returned, Output) else Output(returned)
    try:
        is_valid = (
            isfinite(output.acceleration)
            and all(map(isfinite, output.state))
            and not any(map(isinf, output.logged))
            and (len(output.state), len(output.logged)) == (len(law.state), len(law.columns))
        )
    except TypeError:
        is_valid = False
    if not is_valid:
        raise useless(f"law {law.name}", law.acceleration, f"returned {why_invalid(output, law)}")
    return output
