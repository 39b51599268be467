"""Errors of what a vehicle knows of a link, as the sensors of a scenario make them."""

from __future__ import annotations

import math

from zenvoy.scenarios import Scenario
from zenvoy.vehicles.estimator import ReadingError


def link_errors(scenario: Scenario) -> tuple[ReadingError, ReadingError]:
    """Return the errors of a link's gap and relative speed, as a vehicle reads or receives them."""
    sensors, control = scenario.sensors, scenario.control
    if control.neighbour_state == "position":  # differences of two readings each
        both = math.sqrt(2.0)
        return (
            ReadingError(
                0.0, control.desired_gap_m, floor=max(both * sensors.position_std_m, 1e-3)
            ),
            ReadingError(both * sensors.error_std, control.desired_speed_mps),
        )
    return (
        ReadingError(sensors.error_std, control.desired_gap_m),
        ReadingError(sensors.error_std, control.desired_speed_mps),
    )


def nominal_variances(scenario: Scenario) -> tuple[float, float]:
    """Return the variances of gap (m²) and relative speed (m²/s²) at their desired values."""
    gap_error, speed_error = link_errors(scenario)
    control = scenario.control
    return (
        gap_error.variance(control.desired_gap_m),
        speed_error.variance(control.desired_speed_mps),
    )
