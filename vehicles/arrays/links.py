"""The links that the vehicles use: to the vehicles ahead and behind, and to the leader."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from zenvoy.laws import Motion, Relative
from zenvoy.laws.relative import NAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.view import Known, Reported
from zenvoy.vehicles.decision import Controller
from zenvoy.vehicles.neighbours import neighbours
from zenvoy.vehicles.steps import NS


@dataclass(frozen=True, kw_only=True)
class Links:
    """The links of runs side by side.

    ahead and behind begin with the nearest vehicle. leader is None if no law needs it. seam_ahead
    and seam_behind are added to differences of reported positions, m, by link.
    """

    ahead: tuple[Link, ...]
    behind: tuple[Link, ...]
    seam_ahead: tuple[Floats, ...]
    seam_behind: tuple[Floats, ...]
    leader: Link | None

    @property
    def every(self) -> list[Link]:
        """All links, as a list."""
        return [*self.ahead, *self.behind, *([] if self.leader is None else [self.leader])]


def links_of(
    scenario: Scenario,
    timing: Timing,
    controllers: Sequence[Controller],
    runs: int,
    vehicles: Sequence[int],
) -> Links:
    """Return the links of some vehicles that these controllers use at some time.

    Senders are vehicles of the whole fleet, of which each run has a copy.
    """
    size = scenario.fleet.size
    each = [neighbours(scenario, vehicle, controllers) for vehicle in vehicles]
    m = max(1, *(one.law.sides(one.parameters) for one in controllers))
    base = np.repeat(np.arange(runs, dtype=np.int64) * size, len(vehicles))

    def link(numbers: Sequence[int]) -> Link:
        sender = np.tile(np.array(numbers, dtype=np.int64), runs)
        return Link(timing, np.where(sender > 0, base + sender - 1, -1))

    def nth(side: str, j: int) -> list[int]:
        return [(*getattr(one, side), *(0,) * m)[j] for one in each]

    def seam(side: str, j: int) -> Floats:
        return np.tile(np.array([(*getattr(one, side), *(0.0,) * m)[j] for one in each]), runs)

    has_leader = any(one.leader for one in each)
    return Links(
        ahead=tuple(link(nth("ahead", j)) for j in range(m)),
        behind=tuple(link(nth("behind", j)) for j in range(m)),
        seam_ahead=tuple(seam("seam_ahead", j) for j in range(m)),
        seam_behind=tuple(seam("seam_behind", j) for j in range(m)),
        leader=link([one.leader for one in each]) if has_leader else None,
    )


def reported(link: Link, cycle: int, from_m: Floats, steps: Floats | float) -> Reported:
    """Return the motion that the senders of a link report, as `Radio.motion_of` does."""
    newest = link.newest
    motion = Motion(
        newest.speed,
        newest.plan.values[0] if newest.plan.values else newest.acceleration,
        newest.position - from_m,
        link.age_ns(cycle) * NS,
        NAN if newest.command is None else newest.command,
        steps,
    )
    return Reported(motion, fresh(link, cycle))


def fresh(link: Link, cycle: int) -> Bools | None:
    """Return where the newest beacon may be used in a cycle; None means everywhere."""
    return None if link.all_of(cycle) else link.fresh(cycle)


def radar_of(link: Link, cycle: int) -> Known:
    """Return the radar readings of the senders of a link."""
    newest = link.newest
    return Known(Relative(newest.gap, newest.relative_speed), fresh(link, cycle))


class Chains(NamedTuple):
    """Relative states to the 1st, 2nd, … vehicle ahead and behind.

    known is the number of vehicles that are known on both sides.
    """

    ahead: list[Known]
    behind: list[Known]
    known: Ints

    @property
    def pairs(self) -> tuple[tuple[Relative, Relative], ...]:
        """The states ahead and behind, in pairs."""
        both = zip(self.ahead, self.behind, strict=True)
        return tuple((one.state, other.state) for one, other in both)


def by_radar(links: Links, own: Relative, cycle: int) -> Chains:
    """Return chains as sums of radar readings, as `Radio.chains` does."""
    ahead = [Known(own), *(radar_of(link, cycle) for link in links.ahead[:-1])]
    behind = [radar_of(link, cycle) for link in links.behind]
    return _chains(links, _summed(ahead), _summed(behind))


def by_position(links: Links, here: Floats, v: Floats, cycle: int) -> Chains:
    """Return chains from reported positions, own positions `here` (m) and own speeds v (m/s)."""
    ahead, behind = [], []
    for link, seam in zip(links.ahead, links.seam_ahead, strict=True):
        newest = link.newest
        state = Relative(newest.position + seam - here, newest.speed - v)
        ahead.append(Known(state, fresh(link, cycle)))
    for link, seam in zip(links.behind, links.seam_behind, strict=True):
        newest = link.newest
        state = Relative(here - newest.position + seam, v - newest.speed)
        behind.append(Known(state, fresh(link, cycle)))
    return _chains(links, ahead, behind)


def gap_then(
    heard: Beacons, position: Floats, speed: Floats, seam: Floats, *, ahead: bool
) -> tuple[Floats, Floats]:
    """Return the state of a link at the time of a beacon, from both positions at that time."""
    if ahead:
        return heard.position + seam - position, heard.speed - speed
    return position - heard.position + seam, speed - heard.speed


def _summed(links: list[Known]) -> list[Known]:
    """Return the states over 1, 2, … links; a state is known where all its links are."""
    sums = []
    p = v = 0.0
    there: Bools | None = None
    for link in links:
        p, v = p + link.state.p, v + link.state.v
        if link.there is not None:
            there = link.there if there is None else there & link.there
        sums.append(Known(Relative(p, v), there))
    return sums


def _chains(links: Links, ahead: list[Known], behind: list[Known]) -> Chains:
    count = np.zeros(len(links.ahead[0].exists), dtype=np.int64)
    reaches = np.ones(len(count), dtype=np.bool_)
    pairs = zip(ahead, behind, links.ahead, links.behind, strict=True)
    for one, other, link_ahead, link_behind in pairs:
        reaches = reaches & link_ahead.exists & link_behind.exists
        for known in (one, other):
            if known.there is not None:
                reaches = reaches & known.there
        count += reaches
    return Chains(ahead, behind, count)
