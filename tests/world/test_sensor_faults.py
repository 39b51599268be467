"""Faulty sensors change the readings of their vehicles by what the scenario says, and no others."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.faults import scenario_with
from zenvoy.world.sensor_faults import SensorFaults
from zenvoy.world.sensors import Readings

Floats = NDArray[np.float64]

SIZE, CYCLES, PERIOD_NS = 6, 60, 100_000_000
NAMES: Final = ("gap", "relative_speed", "position", "speed", "acceleration")
# Different in each reading, cycle and vehicle, so that a wrong one is found.
TRUE: Final = {
    name: 100.0 * (place + 1) + np.arange(CYCLES)[:, None] + 0.01 * np.arange(SIZE)
    for place, name in enumerate(NAMES)
}
WHEN: Final = {"vehicles": "2, 5", "at_s": 2.0, "duration_s": 3.0}
WHO, IN_FORCE = np.array([1, 4]), slice(20, 50)


def read(*faults: dict[str, Any], seed: int = 1) -> dict[str, Floats]:
    """Return all readings by name, (cycle, vehicle)."""
    sensors = SensorFaults(scenario_with(faults, size=SIZE, seed=seed))
    rows: dict[str, list[Floats]] = {name: [] for name in NAMES}
    for cycle in range(CYCLES):
        true = {name: value[cycle].copy() for name, value in TRUE.items()}
        felt = true.pop("acceleration")
        found, acceleration = sensors.read(Readings(**true), felt, cycle, cycle * PERIOD_NS)
        for name, value in (*found._asdict().items(), ("acceleration", acceleration)):
            rows[name].append(value)
    return {name: np.array(values) for name, values in rows.items()}


def change(found: dict[str, Floats], name: str) -> Floats:
    """Return by how much a reading differs, (cycle, vehicle) of those hit, in force."""
    return (found[name] - TRUE[name])[IN_FORCE][:, WHO]


def assert_others_are_true(found: dict[str, Floats], *changed: str) -> None:
    for name in NAMES:
        hit = np.zeros((CYCLES, SIZE), np.bool_)
        if name in changed:
            hit[IN_FORCE, WHO[0]] = hit[IN_FORCE, WHO[1]] = True
        assert np.array_equal(found[name][~hit], TRUE[name][~hit])


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("gap_m", "gap"),
        ("relative_speed_mps", "relative_speed"),
        ("position_m", "position"),
        ("speed_mps", "speed"),
        ("acceleration_mps2", "acceleration"),
    ],
)
def test_a_bias_is_added_exactly(key: str, name: str) -> None:
    found = read({"type": "sensor-biased", **WHEN, key: -2.5})
    assert np.array_equal(found[name][IN_FORCE][:, WHO], (TRUE[name] - 2.5)[IN_FORCE][:, WHO])
    assert_others_are_true(found, name)


def test_a_drift_is_linear_from_its_begin() -> None:
    found = read({"type": "sensor-drifting", **WHEN, "gap_mps": 0.5, "speed_mps2": -1.0})
    since_s = 0.1 * np.arange(30)[:, None]
    np.testing.assert_allclose(change(found, "gap"), 0.5 * since_s + np.zeros(2), atol=1e-12)
    np.testing.assert_allclose(change(found, "speed"), -since_s + np.zeros(2), atol=1e-12)
    assert_others_are_true(found, "gap", "speed")


def test_a_blind_radar_reads_nothing() -> None:
    found = read({"type": "sensor-blind", **WHEN})
    assert np.isnan(change(found, "gap")).all()
    assert np.isnan(change(found, "relative_speed")).all()
    assert_others_are_true(found, "gap", "relative_speed")


@pytest.mark.parametrize("sensor", ["radar", "position", "speed", "acceleration", "all"])
def test_a_frozen_sensor_repeats_its_first_reading(sensor: str) -> None:
    found = read({"type": "sensor-frozen", **WHEN, "sensor": sensor})
    frozen = {"radar": ("gap", "relative_speed"), "all": NAMES}.get(sensor, (sensor,))
    for name in frozen:
        first = TRUE[name][20, WHO]
        assert np.array_equal(found[name][IN_FORCE][:, WHO], np.tile(first, (30, 1)))
    assert_others_are_true(found, *frozen)


def test_jumps_have_their_share_and_size_and_are_drawn_by_seed() -> None:
    fault = {"type": "sensor-jumping", **WHEN, "share": 0.4, "gap_m": 8.0}
    found = read(fault, seed=5)
    off = change(found, "gap")
    assert set(np.round(off, 9).ravel()) == {-8.0, 0.0, 8.0}
    # 60 draws: the standard deviation of the share is 0.063.
    assert np.mean(off != 0.0) == pytest.approx(0.4, abs=0.25)
    assert np.array_equal(read(fault, seed=5)["gap"], found["gap"])
    assert not np.array_equal(read(fault, seed=6)["gap"], found["gap"])
    assert_others_are_true(found, "gap")


def test_faults_act_in_the_order_of_the_list() -> None:
    biased = {"type": "sensor-biased", **WHEN, "at_s": 1.0, "duration_s": 2.0, "gap_m": 5.0}
    frozen = {"type": "sensor-frozen", **WHEN, "sensor": "radar"}
    froze_the_bias = read(biased, frozen)["gap"][49, WHO]
    assert np.array_equal(froze_the_bias, TRUE["gap"][20, WHO] + 5.0)
    biased_the_frozen = read(frozen, biased)["gap"][[25, 49]][:, WHO]
    first = TRUE["gap"][20, WHO]
    assert np.array_equal(biased_the_frozen, np.array([first + 5.0, first]))


@given(
    at_s=st.floats(0.0, 8.0),
    duration_s=st.floats(0.01, 8.0),
    gap_m=st.floats(-50.0, 50.0).filter(bool),
)
def test_a_fault_acts_from_its_begin_until_before_its_end(
    at_s: float, duration_s: float, gap_m: float
) -> None:
    fault = {"type": "sensor-biased", "vehicles": "all", "at_s": at_s, "duration_s": duration_s}
    found = read({**fault, "gap_m": gap_m})["gap"]
    time_ns = np.arange(CYCLES) * PERIOD_NS
    start_ns, end_ns = round(at_s * 1e9), round((at_s + duration_s) * 1e9)
    hit = (time_ns >= start_ns) & (time_ns < end_ns)
    assert np.array_equal(found[~hit], TRUE["gap"][~hit])
    assert np.array_equal(found[hit], TRUE["gap"][hit] + gap_m)
