"""How fast waves grow on a ring whose vehicles have different laws, without delay.

The laws are linearised numerically at their common equilibrium, so they need no linear form. They
decide on the true states; a law that keeps a state has none here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.laws import Law, Observation, Output, Relative, Setpoint, law_of
from zenvoy.scenarios import Scenario, parameters_of, roster, setpoint_at

Floats = NDArray[np.float64]

_STEP: Final = 1e-4  # m and m/s; of differences
_STANDS: Final = 1e-6  # 1/s; exponents nearer to 0 shift the fleet, and are no waves


class Driver(NamedTuple):
    """A law with its parameters, and what the scenario sets for its vehicle."""

    law: Law
    parameters: Any
    setpoint: Setpoint


class Equilibrium(NamedTuple):
    """Gap from front to front (m), speed (m/s) and length (m) of all vehicles."""

    gap_m: float
    speed_mps: float
    length_m: float


def growth_per_s(scenario: Scenario) -> float:
    """Return the growth rate of the fastest wave on the ring of a scenario, 1/s; negative: decay.

    All vehicles have the laws of the start, and the desired speed is that of the equilibrium.
    """
    drivers = []
    for settings in roster(scenario):
        law, setpoint = law_of(settings.phases[0].model), setpoint_at(settings.targets, 0)
        parameters = parameters_of(scenario.control, law, settings.phases[0].parameters)
        drivers.append(Driver(law, parameters, setpoint))
    fleet = scenario.fleet
    at = Equilibrium(fleet.gap_m, scenario.control.desired_speed_mps, fleet.length_m)
    return growth_of(drivers, at)


def growth_of(drivers: Sequence[Driver], at: Equilibrium) -> float:
    """Return the largest real part of the exponents of a ring of drivers, 1/s."""
    n = len(drivers)
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    for column in range(2 * n):
        deviation = np.zeros(2 * n)
        deviation[column] = _STEP
        above, below = (_accelerations(drivers, at, sign * deviation) for sign in (1.0, -1.0))
        matrix[n:, column] = (above - below) / (2.0 * _STEP)
    exponents = np.linalg.eigvals(matrix)
    return float(exponents[np.abs(exponents) > _STANDS].real.max())


def _accelerations(drivers: Sequence[Driver], at: Equilibrium, deviation: Floats) -> Floats:
    """Return the accelerations (n,) for deviations of positions and speeds (2 n,)."""
    n = len(drivers)
    position = deviation[:n] - at.gap_m * np.arange(n)
    speed = at.speed_mps + deviation[n:]
    return np.array([_decided(one, i, position, speed, at) for i, one in enumerate(drivers)])


def _decided(driver: Driver, i: int, position: Floats, speed: Floats, at: Equilibrium) -> float:
    m = max(1, driver.law.sides(driver.parameters))
    sides = tuple((_link(i, -j, position, speed, at), _link(i, j, position, speed, at))
                  for j in range(1, m + 1))  # fmt: skip
    seen = Observation(
        float(speed[i]), driver.setpoint, *sides[0], sides=sides, length_m=at.length_m
    )
    returned = driver.law.acceleration(seen, driver.parameters)
    return float(returned.acceleration if isinstance(returned, Output) else returned)


def _link(i: int, by: int, position: Floats, speed: Floats, at: Equilibrium) -> Relative:
    """Return the link from vehicle i to the one `by` places behind, or ahead where it is < 0."""
    n = len(position)
    laps, other = divmod(i + by, n)
    gap = position[i] - (position[other] - laps * n * at.gap_m)
    sign = 1.0 if by > 0 else -1.0
    return Relative(float(sign * gap), float(sign * (speed[i] - speed[other])))
