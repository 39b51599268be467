"""What the vehicles estimate and predict: their own speeds, and links by themselves or shared."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from zenvoy.laws import Relative, law_of
from zenvoy.scenarios import Scenario, Settings
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.filters import SpeedFilters
from zenvoy.vehicles.arrays.knowledge import Estimators
from zenvoy.vehicles.arrays.links import Links
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.rows import ALL, Bools, Rows
from zenvoy.vehicles.arrays.shared_links import Logged, SharedLinks
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.arrays.view import Known, Seen
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.steps import NS


class Roles(NamedTuple):
    """Masks: vehicles that run filters, and those of them that act on shared estimates."""

    estimate: Bools
    share: Bools

    @classmethod
    def of(cls, settings: Sequence[Settings]) -> Roles:
        """Return the roles of vehicles with these settings, by their laws."""
        needs = [[law_of(model).needs for model in one.models] for one in settings]
        return cls(
            np.array([any(each.prediction for each in one) for one in needs]),
            np.array([any(each.shares_links for each in one) for one in needs]),
        )


class Estimation:
    """The estimates of all vehicles, of which some need them.

    own: estimates of links by each vehicle itself; None if nobody acts on them. shared: None if
    nobody acts on shared ones.
    """

    def __init__(
        self, scenario: Scenario, timing: Timing, motion: OwnMotion, links: Links, roles: Roles
    ) -> None:
        period_s, sigma = timing.period_ns * NS, scenario.estimator.acceleration_std_mps2
        error = ReadingError(scenario.sensors.error_std, scenario.control.desired_speed_mps)
        by_position = scenario.control.neighbour_state == "position"
        self._timing, self._motion, self.roles = timing, motion, roles
        self.speed = SpeedFilters(period_s, sigma, error, len(roles.estimate))
        self.own: Estimators | None = None
        self.shared: SharedLinks | None = None
        if (roles.estimate & ~roles.share).any():
            self.own = Estimators(scenario, timing, motion, links, by_position=by_position)
        if roles.share.any():
            self.shared = SharedLinks(scenario, timing, motion, links)
        self.predicted: Seen | None = None
        """The newest predictions to the effect of the commands."""

    def logged(self, side: str, cycle: int) -> Logged:
        """Return the estimates of the links `ahead` or `behind` that the vehicles act on."""
        own = None if self.own is None else _logged(self.own, side)
        if self.shared is None:
            assert own is not None
            return own
        shared = self.shared.logged_ahead(cycle) if side == "ahead" else self.shared.logged_behind
        if own is None:
            return shared
        share = self.roles.share
        return Logged(
            _chosen(share, shared.state, own.state),
            np.where(share, shared.measured, own.measured),
            lambda: np.where(share, shared.std(), own.std()),
        )

    def sense(self, cycle: int, beacons: Beacons) -> Beacons:
        """Process the readings of a cycle, and return the complete beacons."""
        if self.own is not None:
            self.own.sense(cycle, beacons)
        if self.shared is None:
            return beacons
        return beacons._replace(shared=self.shared.sense(cycle, beacons))

    def hear(self, link: Link, cycle: int, now: int, rows: Rows, beacons: Beacons) -> None:
        """Process beacons of a cycle that a link has delivered in cycle `now`."""
        hear = link.hear if self.own is None else partial(self.own.hear, link)
        heard = hear(cycle, rows, beacons)
        if self.shared is not None:
            self.shared.hear(link, cycle, now, rows, heard)

    def estimate(self, cycle: int, beacons: Beacons, radar: Rows, wanted: Bools | None) -> Seen:
        """Estimate at t_cycle, and return predictions to the effect of the commands.

        radar selects the vehicles with a vehicle ahead. wanted is a mask of those whose own
        estimate of the link behind is used; None means all of them.
        """
        self.speed.measure(beacons.speed, beacons.acceleration)
        assert self.speed.v is not None
        _, change = self._motion.over(cycle, self._timing.effect_ns, ALL)
        speed = np.maximum(0.0, self.speed.v + change)
        if self.own is not None:
            ahead, behind = self.own.estimate(cycle, beacons, radar, wanted)
        if self.shared is not None:
            shared = self.shared.predict(cycle)
            if self.own is None:
                ahead, behind = shared
            else:
                share = self.roles.share
                ahead, behind = _mixed(share, shared[0], ahead), _mixed(share, shared[1], behind)
        self.predicted = Seen(ahead, behind, speed)
        return self.predicted


def _mixed(mask: Bools, chosen: Known, otherwise: Known) -> Known:
    """Return the states of `chosen` for the vehicles of the mask, and of `otherwise` for others."""
    all_of = np.ones(len(mask), dtype=np.bool_)
    there = [all_of if one.there is None else one.there for one in (chosen, otherwise)]
    return Known(_chosen(mask, chosen.state, otherwise.state), np.where(mask, *there))


def _chosen(mask: Bools, chosen: Relative, otherwise: Relative) -> Relative:
    pairs = zip(chosen, otherwise, strict=True)
    return Relative(*(np.where(mask, one, other) for one, other in pairs))


def _logged(own: Estimators, side: str) -> Logged:
    """Return what the vehicles' own filters of a link have to log."""
    filters = own.link_ahead if side == "ahead" else own.link_behind
    return Logged(Relative(filters.p, filters.v), filters.measured, filters.covariances.std)
