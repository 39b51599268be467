"""Fuel and CO₂ are compared with hand calculations and with SUMO's program."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.analysis.measures.emissions import co2_rate, coasting, consumption, fuel_rate

# emissionsDrivingCycle of SUMO 1.28.0 (PyPI: eclipse-sumo), class HBEFA3/PC_G_EU4, a line per
# row of its output: speed (m/s), acceleration (m/s²), CO₂ (mg/s), fuel (mg/s).
SUMO = [
    (0.0, 0.0, 2624.72, 837.222),
    (0.3, -2.0, 2430.1, 775.148),
    (1.0, -0.04, 2492.4, 795.012),
    (1.0, -0.06, 0.0, 0.0),
    (5.0, 1.5, 4127.22, 1316.42),
    (13.9, 0.0, 2337.9, 745.693),
    (20.0, -0.3, 1605.72, 512.167),
    (20.0, -0.4, 0.0, 0.0),
    (30.0, 0.0, 5797.22, 1849.06),
    (30.0, 0.5, 9707.22, 3096.14),
    (30.0, -0.45, 2278.22, 726.681),
    (30.0, -0.5, 0.0, 0.0),
    (36.5, -0.58, 2828.7, 902.283),
]
# The same program: the point where its output jumps to 0, by bisection.
COASTING = [
    (0.6, -0.031102808),
    (1.0, -0.051838014),
    (2.7777777, -0.143994479),
    (2.7777778, -0.143994483),
    (5.0, -0.172831462),
    (10.0, -0.237714665),
    (20.0, -0.367481070),
    (30.0, -0.497247475),
    (40.0, -0.627013881),
]


@pytest.mark.parametrize(("v", "a", "co2", "fuel"), SUMO)
def test_rates_equal_those_of_sumo(v: float, a: float, co2: float, fuel: float) -> None:
    speed, acceleration = np.array([v]), np.array([a])
    assert co2_rate(speed, acceleration)[0] == pytest.approx(co2, rel=2e-5)
    assert fuel_rate(speed, acceleration)[0] == pytest.approx(fuel, rel=2e-5)


@pytest.mark.parametrize(("v", "a"), COASTING)
def test_coasting_equals_that_of_sumo(v: float, a: float) -> None:
    assert coasting(np.array([v]))[0] == pytest.approx(a, abs=1e-9)


def test_rates_by_hand() -> None:
    """30 m/s at 0.5 m/s²: 9449 + 938.4 · 15 - 467.1 · 30 + 28.26 · 900 = 34946 g/h of CO₂."""
    assert co2_rate(np.array([30.0]), np.array([0.5]))[0] == pytest.approx(34946.0 / 3.6)
    assert fuel_rate(np.array([30.0]), np.array([0.0]))[0] == pytest.approx(
        (3014.0 - 149.0 * 30.0 + 9.014 * 900.0) / 3.6
    )
    assert fuel_rate(np.array([0.0]), np.array([0.0]))[0] == pytest.approx(3014.0 / 3.6)  # idle


def test_consumption_of_a_steady_fleet() -> None:
    """1849.06 mg/s at 30 m/s are 61.64 mg/m, or 8.307 l/100 km; 5797.22 mg/s are 193.2 g/km."""
    found = consumption(np.full((100, 7), 30.0), np.zeros((100, 7)))
    assert found is not None
    assert found.fuel_l_per_100km == pytest.approx(1849.06 / 30.0 / 742.0 * 100.0, rel=1e-5)
    assert found.fuel_l_per_100km == pytest.approx(8.307, abs=1e-3)
    assert found.co2_g_per_km == pytest.approx(193.24, abs=1e-2)


def test_standing_vehicles_burn_fuel_without_distance() -> None:
    assert consumption(np.zeros((10, 3)), np.zeros((10, 3))) is None
    moving = consumption(np.array([[20.0, 20.0]]), np.zeros((1, 2)))
    half_standing = consumption(np.array([[20.0, 0.0]]), np.zeros((1, 2)))
    assert moving is not None
    assert half_standing is not None
    idle = 3014.0 / 3.6 / 20.0 / 742.0 * 100.0  # of the standing vehicle, per distance of the other
    extra = half_standing.fuel_l_per_100km - moving.fuel_l_per_100km
    assert extra == pytest.approx(idle)


@given(st.floats(0.0, 60.0), st.floats(-9.0, 9.0))
def test_rates_are_never_negative_and_zero_in_overrun(v: float, a: float) -> None:
    speed, acceleration = np.array([v]), np.array([a])
    for rate in (co2_rate, fuel_rate):
        value = rate(speed, acceleration)[0]
        assert value >= 0.0
        if v > 0.5 and a < coasting(speed)[0]:
            assert value == 0.0
        elif a >= 0.0:
            assert value > 0.0
            assert rate(speed, acceleration + 0.1)[0] >= value
