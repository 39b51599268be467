"""Whether the vehicles of a process may run as arrays, which is faster and gives the same bits."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from zenvoy.laws import builtin, law_of
from zenvoy.laws.estimator import KALMAN
from zenvoy.scenarios import Scenario, roster
from zenvoy.vehicles.arrays.beaconing import RULES
from zenvoy.vehicles.control import controllers
from zenvoy.vehicles.neighbours import neighbours


def suited(scenario: Scenario, vehicles: Sequence[int], known: Collection[int]) -> bool:
    """Return whether arrays run these vehicles of a scenario, whatever its channel does.

    known: vehicles that are programs of ours. A guest may send a beacon with any plan, which
    arrays cannot hold.
    """
    if scenario.faults or scenario.beacons.rule not in RULES:
        return False
    members = [roster(scenario)[one - 1] for one in vehicles]
    models = {model for one in roster(scenario) for model in one.models}
    needs = [law_of(model).needs for model in models]
    if any(model not in builtin() for model in models) or any(one.shares_links for one in needs):
        return False
    if any(one.lag_s > 0.0 for one in roster(scenario)):
        return False
    if any(one.prediction for one in needs) and (
        scenario.estimator.kind != KALMAN or scenario.control.neighbour_state == "position"
    ):
        return False
    every = [controller for one in members for _, controller in controllers(scenario, one)]
    used = {other for one in vehicles for other in neighbours(scenario, one, every).everyone}
    return used <= {*known, *vehicles}
