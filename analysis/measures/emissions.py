"""Fuel and CO₂ of a Euro 4 petrol car, computed as SUMO does for its class HBEFA3/PC_G_EU4.

SUMO fits the handbook's emission factors (HBEFA 3.1) by a polynomial in speed v and acceleration
a (eclipse-sumo/sumo, src/utils/emissions/HelpersHBEFA3.h, `compute`; coefficients in
HelpersHBEFA3.cpp, `myFunctionParameter`, "PC_G_EU4"):

    max(0, (f0 + f1 a v + f2 a² v + f3 v + f4 v² + f5 v³) / 3.6) mg/s

- The engine idles while the car stands, or brakes at walking pace: the polynomial is f0 / 3.6 at
  v = 0.
- From 0.5 m/s on, a car that slows down faster than it would by coasting burns nothing. SUMO of
  2020 returned 0 for every a < 0, which halves the fuel of a car with a small, noisy acceleration.
- A polynomial below zero counts as zero.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# f0 .. f5 of PC_G_EU4, in g/h.
_CO2: Final = (9449.0, 938.4, 0.0, -467.1, 28.26, 0.0)
_FUEL: Final = (3014.0, 299.3, 0.0, -149.0, 9.014, 0.0)
PETROL_G_PER_L: Final = 742.0
"""Density of petrol, as in SUMO."""
# Coasting is -(c0 + c1 v); below 10 km/h it falls in proportion to v. Measured with the program
# emissionsDrivingCycle of SUMO 1.28.0 for this class, by bisection to 1e-9 m/s² at 12 speeds.
_COASTING: Final = (0.107948259053, 0.012976640547)
_COASTING_FROM_MPS: Final = 10.0 / 3.6
_ROLLING_MPS: Final = 0.5


class Consumption(NamedTuple):
    """Fuel in l/100 km and CO₂ in g/km of a whole fleet, over the distance that it drove."""

    fuel_l_per_100km: float
    co2_g_per_km: float


def co2_rate(speed: Floats, acceleration: Floats) -> Floats:
    """Return CO₂ in mg/s at speeds (m/s) and accelerations (m/s²) of the same shape."""
    return _rate(speed, acceleration, _CO2)


def fuel_rate(speed: Floats, acceleration: Floats) -> Floats:
    """Return petrol in mg/s at speeds (m/s) and accelerations (m/s²) of the same shape."""
    return _rate(speed, acceleration, _FUEL)


def consumption(speed: Floats, acceleration: Floats) -> Consumption | None:
    """Return the consumption for speeds and accelerations (T, n), rows evenly spaced in time.

    It is None for a fleet that stands.
    """
    distance = float(speed.sum())  # in m per period; the period cancels out
    if distance <= 0.0:
        return None
    fuel, co2 = (float(rate(speed, acceleration).sum()) for rate in (fuel_rate, co2_rate))
    return Consumption(fuel / distance / PETROL_G_PER_L * 100.0, co2 / distance)


def coasting(speed: Floats) -> Floats:
    """Return the acceleration of a car that coasts, m/s² (negative)."""
    speed = np.asarray(speed, dtype=np.float64)
    c0, c1 = _COASTING
    slow = np.minimum(speed / _COASTING_FROM_MPS, 1.0)
    return -(c0 + c1 * np.maximum(speed, _COASTING_FROM_MPS)) * slow


def _rate(speed: Floats, acceleration: Floats, f: tuple[float, ...]) -> Floats:
    v, a = np.asarray(speed, dtype=np.float64), np.asarray(acceleration, dtype=np.float64)
    per_hour = f[0] + v * (f[1] * a + f[2] * a * a + f[3] + v * (f[4] + v * f[5]))
    overrun = (v > _ROLLING_MPS) & (a < coasting(v))
    return np.where(overrun, 0.0, np.maximum(per_hour / 3.6, 0.0))
