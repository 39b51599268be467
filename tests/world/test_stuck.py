"""A stuck actuator keeps its acceleration, whatever is commanded."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.faults import scenario_with
from zenvoy.world.fleet import Fleet

Floats = NDArray[np.float64]

STUCK = {"type": "actuator-stuck", "vehicles": 2, "at_s": 1.05, "duration_s": 2.0}


def speeds(fault: dict[str, Any], command: float = 1.0, **settings: Any) -> Floats:
    """Return speeds from 0 to 5 s in steps of 0.1 s, (step, vehicle).

    Everyone gets `command` from the start, and its negative from 2 s on.
    """
    fleet = Fleet(scenario_with([fault], size=3, **settings))
    fleet.command_all(0, np.full(3, command))
    fleet.command_all(2_000_000_000, np.full(3, -command))
    found = []
    for step in range(51):
        fleet.advance_to(step * 100_000_000)
        found.append(fleet.speed)
    return np.array(found)


def test_it_keeps_the_acceleration_that_it_had() -> None:
    speed = speeds(STUCK)
    assert speed[[10, 20, 30], 1] - 30.0 == pytest.approx([1.0, 2.0, 3.0])
    assert speed[50, 1] == pytest.approx(30.0 + 3.05 - 1.95)  # free from 3.05 s on
    assert speed[[20, 50], 0] - 30.0 == pytest.approx([2.0, -1.0])  # a vehicle without the fault


def test_it_may_be_stuck_at_a_given_acceleration() -> None:
    speed = speeds({**STUCK, "acceleration_mps2": -2.0})
    assert speed[30, 1] == pytest.approx(30.0 + 1.05 - 2.0 * 1.95)


def test_it_overrides_a_brake_and_stays_at_standstill() -> None:
    brake = {"type": "brake", "vehicle": 2, "at_s": 1.5, "duration_s": 1.0, "deceleration_mps2": 9}
    assert speeds(STUCK, events=[brake])[30, 1] == pytest.approx(33.0)
    stops = {**STUCK, "acceleration_mps2": -1e6}
    assert speeds(stops)[[11, 30], 1].tolist() == [0.0, 0.0]


def test_with_a_lag_it_is_stuck_at_what_it_gives() -> None:
    speed = speeds(STUCK, vehicle={"actuator_lag_s": 0.5})
    given = 1.0 - math.exp(-1.05 / 0.5)  # of a command of 1 m/s² since 0 s
    at_begin = 1.05 - 0.5 * given
    assert speed[30, 1] - 30.0 == pytest.approx(at_begin + 1.95 * given)
    # From its end on the lag starts from what the actuator gave.
    free_s = 5.0 - 3.05
    lagged = -free_s + (given + 1.0) * 0.5 * (1.0 - math.exp(-free_s / 0.5))
    assert speed[50, 1] - 30.0 == pytest.approx(at_begin + 2.0 * given + lagged)
