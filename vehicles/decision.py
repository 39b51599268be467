"""From what a vehicle knows to an acceleration and the mode behind it."""

from __future__ import annotations

from enum import Enum, auto
from typing import NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.vehicles.controllers import (
    Law,
    Told,
    bilateral,
    cooperative,
    cruising,
    following,
    limited,
    multi_node,
    multi_node_weights,
)
from zenvoy.vehicles.relative import Relative


class Place(Enum):
    """Where a vehicle stands; on the ring everyone is in the middle."""

    FIRST = auto()
    MIDDLE = auto()
    LAST = auto()


class View(NamedTuple):
    """What there is to decide on; None (or nothing) where it is missing or too old.

    radar: the own one's reading; ahead, behind: states of both links, by radar or by positions;
    speed: the own one, m/s. sides: for MBCM, the states to the j-th vehicle ahead and behind,
    j = 1..m, as far as the chain reaches on both sides. told, leader: what the vehicle ahead and
    the leader of the platoon say of themselves.
    """

    radar: Relative | None
    ahead: Relative | None
    behind: Relative | None
    speed: float
    sides: tuple[tuple[Relative, Relative], ...] = ()
    told: Told | None = None
    leader: Told | None = None


class Predicted(NamedTuple):
    """States of both links and own speed (m/s) at the instant the command takes effect."""

    ahead: Relative | None
    behind: Relative | None
    speed: float


class Decision(NamedTuple):
    """Acceleration (m/s²), within the limit, the mode behind it, and MBCM's m (0: not MBCM)."""

    acceleration: float
    mode: pb.Mode.ValueType
    neighbours: int = 0


def decide(model: str, place: Place, read: View, predicted: Predicted | None, law: Law) -> Decision:
    """Acceleration for a vehicle that runs `model`.

    Where what the model needs of others is missing, it falls back to FM on the own radar. The
    ends of the open road follow paper Eq. 5: the first keeps its speed unless the schedule gives
    it one, the last has nobody behind and follows. `predicted` is for PBCM alone.
    """
    if place is Place.FIRST:
        speed = predicted.speed if predicted is not None and model == "PBCM" else read.speed
        return Decision(limited(cruising(speed, law), law), pb.MODE_CONSTANT_SPEED)
    if read.radar is None:
        return Decision(0.0, pb.MODE_CONSTANT_SPEED)
    if model == "FM":
        decision = _follow(read.ahead, read.speed, pb.MODE_FM, law)
    elif model == "CACC":
        decision = _cooperate(read, law)
    elif model == "MBCM" and place is Place.MIDDLE:
        decision = _balance_many(read, law)
    else:
        decision = _balance(model, place, read, predicted, law)
    if decision is None:
        a = limited(following(read.radar, read.speed, law), law)
        return Decision(a, pb.MODE_FALLBACK_FM)
    return decision


def _follow(
    ahead: Relative | None, speed: float, mode: pb.Mode.ValueType, law: Law
) -> Decision | None:
    if ahead is None:
        return None
    return Decision(limited(following(ahead, speed, law), law), mode)


def _balance(
    model: str, place: Place, read: View, predicted: Predicted | None, law: Law
) -> Decision | None:
    """BCM, PBCM on what is predicted, and the last of the open road under any bilateral model."""
    mode = _MODES[model]
    view = predicted if predicted is not None and model == "PBCM" else read
    if place is Place.LAST:
        return _follow(view.ahead, view.speed, mode, law)
    if read.behind is None or view.ahead is None or view.behind is None:
        return None
    return Decision(limited(bilateral(view.ahead, view.behind, view.speed, law), law), mode)


def _balance_many(read: View, law: Law) -> Decision | None:
    m = len(read.sides)
    if m == 0:
        return None
    a = multi_node(read.sides, multi_node_weights(law.weights, m), read.speed, law)
    return Decision(limited(a, law), pb.MODE_MBCM, m)


def _cooperate(read: View, law: Law) -> Decision | None:
    if read.ahead is None or read.told is None or read.leader is None:
        return None
    a = cooperative(read.ahead, read.told, read.leader, read.speed, law)
    return Decision(limited(a, law), pb.MODE_CACC)


_MODES = {"BCM": pb.MODE_BCM, "MBCM": pb.MODE_MBCM, "PBCM": pb.MODE_PBCM}
