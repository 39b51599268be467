"""A lead vehicle follows its speed exactly, whatever else happens."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.commanding import give
from zenvoy.scenarios import (
    Brake,
    Control,
    Road,
    Scenario,
    Sine,
    Trace,
)
from zenvoy.scenarios import Fleet as FleetSettings
from zenvoy.world.fleet import Fleet

T_NS = 100_000_000
S_NS = 1_000_000_000
MS_NS = 1_000_000


def fleet_with(*events: Brake | Sine | Trace, speed_mps: float = 30.0) -> Fleet:
    return Fleet(
        Scenario(
            road=Road(type="open"),
            fleet=FleetSettings(size=3, gap_m=1_000.0, speed_mps=speed_mps),
            control=Control(model="FM"),
            events=events,
        )
    )


def brake(vehicle: int, at_s: float, duration_s: float, deceleration_mps2: float) -> Brake:
    return Brake(
        vehicle=vehicle, at_s=at_s, duration_s=duration_s, deceleration_mps2=deceleration_mps2
    )


def distance(points: list[tuple[int, float]]) -> float:
    """Return the distance, m, of a piecewise linear speed through points (ns, m/s)."""
    return sum((t1 - t0) / S_NS * (v0 + v1) / 2 for (t0, v0), (t1, v1) in pairwise(points))


def test_the_speed_follows_a_sine_at_every_start_of_a_cycle() -> None:
    swing = Sine(
        vehicle=1, at_s=1.0, duration_s=20.0, mean_mps=30, amplitude_mps=2, frequency_hz=0.1
    )
    fleet = fleet_with(swing)
    start_m = fleet.position[0]
    points = []
    for k in range(1, 301):
        give(fleet, [(1, k * T_NS - 30 * MS_NS, (-1.0) ** k)])  # not obeyed in the sine
        fleet.advance_to(k * T_NS)
        t = k * 0.1 - 1.0
        if 0.0 <= t <= 20.0:
            points.append((k * T_NS, 30.0 + 2.0 * sin(2 * pi * 0.1 * t)))
            if t > 0.0:
                assert fleet.speed[0] == pytest.approx(points[-1][1], abs=1e-12)
        if k == 10:
            # commands of ±1 m/s² apply up to here, and again from the end of the sine
            start_m, points[0] = fleet.position[0], (k * T_NS, float(fleet.speed[0]))
        if k == 210:
            assert fleet.position[0] - start_m == pytest.approx(distance(points), abs=1e-8)
    assert len(points) == 201
    assert abs(fleet.acceleration[0]) == 1.0
    assert fleet.speed[1:].tolist() == [30.0, 30.0]


def test_a_chirp_sweeps_its_frequency_evenly() -> None:
    """The phase at t is the integral of the frequency: 2π (f t + (f₁ - f) t² / 2D)."""
    chirp = Sine(
        vehicle=1,
        at_s=0.0,
        duration_s=100.0,
        mean_mps=30,
        amplitude_mps=0.5,
        frequency_hz=0.01,
        to_frequency_hz=0.5,
    )
    fleet = fleet_with(chirp)
    t = np.arange(1, 1001) * 0.1
    frequency = 0.01 + 0.49 * np.linspace(0.0, 100.0, 1_000_001) / 100.0
    turns = np.concatenate([[0.0], np.cumsum((frequency[1:] + frequency[:-1]) / 2) * 1e-4])
    expected = 30.0 + 0.5 * np.sin(2 * pi * turns[np.arange(1, 1001) * 1_000])
    speeds = []
    for k in range(1, 1001):
        fleet.advance_to(k * T_NS)
        speeds.append(fleet.speed[0])
    assert t[-1] == pytest.approx(100.0)
    assert speeds == pytest.approx(expected.tolist(), abs=1e-8)


def test_an_unaligned_sine_has_a_point_at_its_end_too() -> None:
    swing = Sine(
        vehicle=1, at_s=0.25, duration_s=0.4, mean_mps=30, amplitude_mps=3, frequency_hz=1.0
    )
    fleet = fleet_with(swing)
    points = [(250 * MS_NS, 30.0)]
    for ms in (300, 400, 500, 600, 650):
        points.append((ms * MS_NS, 30.0 + 3.0 * sin(2 * pi * (ms - 250) / 1e3)))
    start_m = fleet.position[0]
    for k in range(1, 9):
        fleet.advance_to(k * T_NS)
    expected_m = 0.25 * 30.0 + distance(points) + 0.15 * points[-1][1]
    assert fleet.position[0] - start_m == pytest.approx(expected_m, abs=1e-9)
    assert fleet.speed[0] == pytest.approx(points[-1][1], abs=1e-12)
    assert fleet.acceleration[0] == 0.0


steps_ms = st.lists(st.integers(1, 700), min_size=1, max_size=12)
commanded = st.lists(st.tuples(st.integers(0, 3_000), st.floats(-9.0, 9.0)), max_size=10)


@settings(deadline=None, max_examples=150)
@given(st.integers(0, 500), steps_ms, st.data(), commanded)
def test_any_trace_is_followed_from_point_to_point(
    at_ms: int, steps: list[int], data: st.DataObject, commands: list[tuple[int, float]]
) -> None:
    """Points are at any millisecond, with speeds down to standstill. Commands differ from them."""
    times_ms = np.concatenate([[0], np.cumsum(steps)]).tolist()
    count = len(times_ms)
    speeds = data.draw(st.lists(st.floats(0.0, 40.0), min_size=count, max_size=count))
    trace = Trace(
        vehicle=1,
        at_s=at_ms / 1e3,
        points=tuple((ms / 1e3, v) for ms, v in zip(times_ms, speeds, strict=True)),
    )
    fleet = fleet_with(trace, speed_mps=speeds[0])
    start_m = fleet.position[0]
    late = [(at, a) for at, a in commands if at >= at_ms]  # so it begins at its first point's speed
    give(fleet, [(1, ms * MS_NS, a) for ms, a in late])
    times_s = (np.array(times_ms) + at_ms) / 1e3
    for k in range(1, (at_ms + times_ms[-1]) // 100 + 1):
        fleet.advance_to(k * T_NS)
        assert fleet.speed[0] == pytest.approx(np.interp(k / 10, times_s, speeds), abs=1e-9)
    fleet.advance_to((at_ms + times_ms[-1]) * MS_NS)
    points = [(round(t * 1e3) * MS_NS, v) for t, v in zip(times_s, speeds, strict=True)]
    expected_m = at_ms / 1e3 * speeds[0] + distance(points)
    assert fleet.position[0] - start_m == pytest.approx(expected_m, abs=1e-7)
    assert fleet.speed[0] == pytest.approx(speeds[-1], abs=1e-9)


def test_errors_do_not_add_up_over_many_points() -> None:
    points = tuple((0.05 * i, 30.0 + (i * 7919 % 101) / 37.0) for i in range(10_001))
    fleet = fleet_with(Trace(vehicle=2, at_s=0.0, points=points))
    for k in range(1, 5_001):
        fleet.advance_to(k * T_NS)
        assert fleet.speed[1] == pytest.approx(points[2 * k][1], abs=1e-12)


def test_a_trace_begins_at_its_first_time_and_ends_at_its_last() -> None:
    fleet = fleet_with(Trace(vehicle=1, at_s=1.0, points=((0.5, 30.0), (1.5, 31.0))))
    give(fleet, [(1, 0, 2.0)])
    fleet.advance_to(1_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(33.0, abs=1e-12)
    assert fleet.acceleration[0] == pytest.approx(-2.0, abs=1e-9)  # from 33 to 31 m/s within 1 s
    fleet.advance_to(2_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(31.0, abs=1e-12)
    assert fleet.acceleration[0] == 2.0


@pytest.mark.parametrize("brake_first", [True, False])
def test_a_brake_takes_precedence_and_the_trace_is_met_again_at_its_next_point(
    brake_first: bool,
) -> None:
    trace = Trace(vehicle=1, at_s=0.0, points=((0.0, 30.0), (2.0, 30.0), (4.0, 32.0)))
    hard = brake(1, 1.0, 0.5, 4.0)
    fleet = fleet_with(*((hard, trace) if brake_first else (trace, hard)))
    fleet.advance_to(S_NS)
    assert fleet.acceleration[0] == -4.0
    fleet.advance_to(1_500 * MS_NS)
    assert fleet.speed[0] == pytest.approx(28.0, abs=1e-12)
    assert fleet.acceleration[0] == pytest.approx(4.0, abs=1e-9)  # 2 m/s within 0.5 s
    fleet.advance_to(2 * S_NS)
    assert fleet.speed[0] == pytest.approx(30.0, abs=1e-12)
    fleet.advance_to(3 * S_NS)
    assert fleet.speed[0] == pytest.approx(31.0, abs=1e-12)


def test_a_vehicle_follows_its_trace_into_a_collision() -> None:
    """Vehicle 2 drives at 10 m/s into vehicle 1, which stands, and its speed stays sane."""
    fleet = fleet_with(Trace(vehicle=2, at_s=0.0, points=((0.0, 10.0), (200.0, 10.0))))
    fleet.speed = np.array([0.0, 10.0, 0.0])
    collided = [k for k in range(1, 1_100) if fleet.advance_to(k * T_NS)]
    assert collided[0] == 996  # 995 m at 10 m/s, and then within the cycle
    assert fleet.position[0] - fleet.position[1] == pytest.approx(5.0, abs=1e-8)
    assert fleet.speed[1] == 0.0
