"""From what a vehicle knows to an acceleration and the mode behind it."""

from __future__ import annotations

from enum import Enum, auto
from typing import NamedTuple

from zenvoy.bus import messages_pb2 as pb
from zenvoy.vehicles.controllers import Law, bilateral, following, limited
from zenvoy.vehicles.relative import Relative


class Place(Enum):
    """Where a vehicle stands; on the ring everyone is in the middle."""

    FIRST = auto()
    MIDDLE = auto()
    LAST = auto()


class View(NamedTuple):
    """States of both links, where there are any, and the own speed (m/s)."""

    ahead: Relative | None
    behind: Relative | None
    speed: float


class Decision(NamedTuple):
    """Acceleration (m/s²), within the limit, and the mode behind it."""

    acceleration: float
    mode: pb.Mode.ValueType


def decide(model: str, place: Place, read: View, predicted: View | None, law: Law) -> Decision:
    """Acceleration for a vehicle that runs `model`.

    `read.behind` is None where the data of the vehicle behind are missing or too old: bilateral
    models then fall back to FM on the own radar. The ends of the open road follow paper Eq. 5.
    """
    if place is Place.FIRST or read.ahead is None:
        return Decision(0.0, pb.MODE_CONSTANT_SPEED)
    if model == "FM":
        return Decision(limited(following(read.ahead, read.speed, law), law), pb.MODE_FM)
    view = read if predicted is None else predicted
    mode = pb.MODE_PBCM if model == "PBCM" else pb.MODE_BCM
    if place is Place.LAST and view.ahead is not None:
        return Decision(limited(following(view.ahead, view.speed, law), law), mode)
    if read.behind is None or view.ahead is None or view.behind is None:
        a = limited(following(read.ahead, read.speed, law), law)
        return Decision(a, pb.MODE_FALLBACK_FM)
    return Decision(limited(bilateral(view.ahead, view.behind, view.speed, law), law), mode)
