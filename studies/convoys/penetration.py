"""Cars of today behind a recorded leader, of which a share is equipped with another law."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

from zenvoy.analysis.measures.growth import growth_per_vehicle
from zenvoy.studies.convoys.behind import after_lead_in, motions, settled, under
from zenvoy.studies.convoys.calibration import Calibration
from zenvoy.studies.convoys.groups import group_of, names_of

SHARES: Final = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
EQUIPPED: Final = "PBCM"
_PERIOD_S: Final = 0.1


class Point(NamedTuple):
    """A recording, the share of equipped vehicles, and two choices.

    all_beacon: whether vehicles that are not equipped send beacons, too. settled: whether the
    convoy has settled before the recorded drive, or begins as recorded.
    """

    recording: str
    share: float
    all_beacon: bool
    settled: bool


class Mixed(NamedTuple):
    """Growth of the swing per vehicle, smallest gap (m) and collisions, each for every seed."""

    growth: Sequence[float]
    smallest_gap_m: Sequence[float]
    collisions: Sequence[int]


class Task(NamedTuple):
    """The cars of today, as fitted, a point, and the seeds that draw who is equipped."""

    today: Calibration
    point: Point
    seeds: Sequence[int]


def mixed(task: Task) -> Mixed:
    """Return how the swing grows in a convoy, of which some cars have got another law.

    Equipped vehicles have the default gains. The first vehicle is the recorded leader, whether it
    is drawn or not. If the others send no beacons, an equipped vehicle before one of them falls
    back to FM. Nothing is drawn if none or all are equipped, and one seed is enough.
    """
    point = task.point
    seeds = task.seeds if 0.0 < point.share < 1.0 else task.seeds[:1]
    found = motions(values_for(task.today, point), seeds)
    if point.settled:
        found = [after_lead_in(one, _PERIOD_S) for one in found]
    return Mixed(
        [growth_per_vehicle(one.speed) for one in found],
        [float(one.gap.min()) for one in found],
        [one.collisions for one in found],
    )


def values_for(today: Calibration, point: Point) -> dict[str, Any]:
    """Return the values of the scenario of a point, without its seed."""
    values = under(today.convoy, "FM")
    names = names_of([fit.car for fit in today.fits])
    groups = [
        group_of(today.task, fit.values, name=name, vehicles=vehicle, folder=None)
        for vehicle, (fit, name) in enumerate(zip(today.fits, names, strict=True), start=2)
    ]
    equipped = {"name": "equipped", "share": point.share, "model": EQUIPPED, "gains": {}}
    others = {"name": "others", "vehicles": "not equipped", "beacons": point.all_beacon}
    values["fleet"]["groups"] = [*groups, equipped, others]
    return settled(values) if point.settled else values


def stopping_share(growth: Sequence[float]) -> float | None:
    """Return the share from which on the growth is at most 1; None if there is no such share.

    growth has a value for each of SHARES, and is a straight line between two of them.
    """
    if growth[-1] > 1.0:
        return None
    above = [index for index, value in enumerate(growth) if value > 1.0]
    if not above:
        return 0.0
    last = above[-1]
    part = (growth[last] - 1.0) / (growth[last] - growth[last + 1])
    return SHARES[last] + part * (SHARES[last + 1] - SHARES[last])
