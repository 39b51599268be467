"""Readings have the errors that the settings say, and do not depend on the order of reading."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from zenvoy.scenarios import Sensors
from zenvoy.world.sensors import Readings, SensorSet

Floats = NDArray[np.float64]
Distribution = Literal["uniform", "gaussian"]

SIZE, CYCLES = 20, 500
GAP = np.linspace(10.0, 60.0, SIZE)
POSITION = np.linspace(0.0, -700.0, SIZE)
SPEED = np.linspace(20.0, 35.0, SIZE)


def read(sensors: SensorSet, cycle: int) -> Readings:
    return sensors.read(cycle, GAP, POSITION, SPEED)


def errors(readings: Readings) -> list[Floats]:
    """Return relative errors of the gap, the speed of the vehicle ahead, and the own speed."""
    ahead = np.roll(SPEED, 1)
    target = readings.relative_speed + SPEED
    return [readings.gap / GAP - 1.0, target / ahead - 1.0, readings.speed / SPEED - 1.0]


def all_errors(sensors: SensorSet) -> Floats:
    """Return the errors of all readings, (kind, cycle, vehicle)."""
    cycles = [errors(read(sensors, cycle)) for cycle in range(CYCLES)]
    return np.array(cycles).transpose(1, 0, 2)


@pytest.mark.parametrize("distribution", ["uniform", "gaussian"])
@pytest.mark.parametrize("error", [0.02, 0.1])
def test_errors_have_the_size_of_the_setting(distribution: Distribution, error: float) -> None:
    sensors = SensorSet(Sensors(error=error, distribution=distribution), seed=3, size=SIZE)
    drawn = all_errors(sensors)
    n = CYCLES * SIZE
    variance = error**2 / 3.0  # of both distributions
    kurtosis = 1.8 if distribution == "uniform" else 3.0
    for of_kind in drawn:
        assert abs(of_kind.mean()) < 3.0 * np.sqrt(variance / n)
        spread = np.sqrt((kurtosis - 1.0) / n)  # standard deviation of a measured variance
        assert of_kind.var() == pytest.approx(variance, rel=3.0 * spread)
    if distribution == "uniform":
        assert np.abs(drawn).max() <= error * (1.0 + 1e-12)
        assert np.abs(drawn).max() > 0.999 * error
    else:
        assert np.abs(drawn).max() > 1.5 * error  # normal draws are unbounded


def test_errors_of_vehicles_cycles_and_kinds_are_independent() -> None:
    drawn = all_errors(SensorSet(Sensors(error=0.1), seed=3, size=SIZE))
    flat = drawn.reshape(3, -1)
    pairs = [(flat[0], flat[1]), (flat[0], flat[2]), (flat[1], flat[2])]
    for kind in drawn:
        pairs += [
            (kind[1:].ravel(), kind[:-1].ravel()),
            (kind[:, 1:].ravel(), kind[:, :-1].ravel()),
        ]
    for a, b in pairs:
        assert abs(np.corrcoef(a, b)[0, 1]) < 3.5 / np.sqrt(len(a))


@settings(deadline=None, max_examples=30)
@given(
    st.lists(st.integers(0, 400), min_size=1, max_size=12),
    st.sampled_from(["uniform", "gaussian"]),
)
def test_cycles_may_be_read_in_any_order(cycles: list[int], distribution: Distribution) -> None:
    given_settings = Sensors(error=0.1, distribution=distribution, position_std_m=1.0)
    sensors = SensorSet(given_settings, seed=5, size=SIZE)
    for cycle in cycles:
        anew = SensorSet(given_settings, seed=5, size=SIZE)
        for one, other in zip(read(sensors, cycle), read(anew, cycle), strict=True):
            np.testing.assert_array_equal(one, other)


def test_a_vehicle_reads_the_same_in_a_larger_fleet() -> None:
    large, small = (SensorSet(Sensors(error=0.1), seed=5, size=size) for size in (SIZE, 7))
    of_small = small.read(9, GAP[:7], POSITION[:7], SPEED[:7])
    np.testing.assert_array_equal(read(large, 9).gap[:7], of_small.gap)
    np.testing.assert_array_equal(read(large, 9).speed[:7], of_small.speed)


def test_another_seed_gives_other_readings() -> None:
    one, other = (SensorSet(Sensors(error=0.1), seed=seed, size=SIZE) for seed in (1, 2))
    assert (read(one, 0).gap != read(other, 0).gap).all()


@pytest.mark.parametrize("distribution", ["uniform", "gaussian"])
def test_without_error_the_truth_is_read(distribution: Distribution) -> None:
    sensors = SensorSet(Sensors(error=0.0, distribution=distribution), seed=1, size=SIZE)
    for cycle in (0, 63, 64, 1_000):
        readings = read(sensors, cycle)
        np.testing.assert_array_equal(readings.gap, GAP)
        np.testing.assert_array_equal(readings.relative_speed, np.roll(SPEED, 1) - SPEED)
        np.testing.assert_array_equal(readings.position, POSITION)
        np.testing.assert_array_equal(readings.speed, SPEED)


def test_positions_are_read_with_an_error_in_metres() -> None:
    sensors = SensorSet(Sensors(error=0.0, position_std_m=2.0), seed=1, size=SIZE)
    wrong = np.array([read(sensors, cycle).position - POSITION for cycle in range(CYCLES)])
    assert wrong.std() == pytest.approx(2.0, rel=3.0 * np.sqrt(0.5 / wrong.size))
    assert abs(wrong.mean()) < 3.0 * 2.0 / np.sqrt(wrong.size)


def test_nothing_is_ahead_of_the_first_vehicle_on_the_open_road() -> None:
    gap = GAP.copy()
    gap[0] = np.nan
    readings = SensorSet(Sensors(error=0.1), seed=1, size=SIZE).read(0, gap, POSITION, SPEED)
    for values in (readings.gap, readings.relative_speed):
        assert np.isnan(values[0])
        assert not np.isnan(values[1:]).any()
