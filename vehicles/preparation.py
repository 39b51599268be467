"""Gains that all vehicles need, computed before the processes of a run are forked."""

from __future__ import annotations

from zenvoy.laws.estimator import KALMAN
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.control import shares_links
from zenvoy.vehicles.estimator import ReadingError
from zenvoy.vehicles.gains import gain_schedule, settle
from zenvoy.vehicles.link_errors import nominal_variances
from zenvoy.vehicles.unheard import unheard_gains


def prepare(scenario: Scenario) -> None:
    """Compute the gains of a steady flow, for the processes that are forked from this one."""
    period_s, of_links = scenario.period_ns * 1e-9, nominal_variances(scenario)
    if shares_links(scenario):
        unheard_gains(period_s, of_links)
    if scenario.estimator.kind != KALMAN:
        return  # other filters share nothing
    speed = scenario.control.desired_speed_mps
    own = ReadingError(scenario.sensors.error_std, speed).variance(speed)
    for variances in (of_links, (own,)):
        settle(gain_schedule(period_s, scenario.estimator.acceleration_std_mps2, variances))
