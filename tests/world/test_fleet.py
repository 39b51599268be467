"""The true fleet obeys commands and brakes inside cycles, stands still, and collides."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.commanding import give
from zenvoy.scenarios import Brake, Control, Road, Scenario
from zenvoy.scenarios import Fleet as FleetSettings
from zenvoy.world.fleet import Fleet

T_NS = 100_000_000
S_NS = 1_000_000_000
MS_NS = 1_000_000


def scenario(
    *,
    size: int = 3,
    gap_m: float = 1_000.0,
    speed_mps: float = 10.0,
    brakes: tuple[Brake, ...] = (),
    ring: bool = True,
) -> Scenario:
    return Scenario(
        road=Road(type="ring" if ring else "open"),
        fleet=FleetSettings(size=size, gap_m=gap_m, speed_mps=speed_mps),
        control=Control(model="FM"),
        events=brakes,
    )


def brake(vehicle: int, at_s: float, duration_s: float, deceleration_mps2: float) -> Brake:
    return Brake(
        vehicle=vehicle, at_s=at_s, duration_s=duration_s, deceleration_mps2=deceleration_mps2
    )


def exact(
    p: float,
    v: float,
    steps: list[tuple[int, float]],
    brakes: list[tuple[int, int, float]],
    until_ns: int,
) -> tuple[float, float]:
    """Move a vehicle by the closed form. Steps are (from_ns, a), brakes (from_ns, until_ns, a)."""
    instants = {0, until_ns, *(t for t, _ in steps), *(t for b in brakes for t in b[:2])}
    times = sorted(t for t in instants if 0 <= t <= until_ns)
    for now_ns, next_ns in pairwise(times):
        a = ([0.0] + [value for from_ns, value in steps if from_ns <= now_ns])[-1]
        a = max(-3.0, min(3.0, a))
        hardest = [b for from_ns, end_ns, b in brakes if from_ns <= now_ns < end_ns]
        if hardest:
            a = -max(hardest)
        dt = (next_ns - now_ns) / S_NS
        if v + a * dt < 0.0:
            p, v = p + v * v / (-2.0 * a), 0.0
        else:
            p, v = p + v * dt + a * dt * dt / 2.0, v + a * dt
    return p, v


ms = st.integers(0, 2_000)
commands = st.lists(st.tuples(st.integers(1, 3), ms, st.floats(-5.0, 5.0)), max_size=12)
brakings = st.lists(
    st.tuples(st.integers(1, 3), ms, st.integers(1, 900), st.floats(0.5, 9.0)), max_size=3
)


@settings(deadline=None, max_examples=150)
@given(commands, brakings, st.floats(0.0, 4.0))
def test_agrees_with_the_closed_form(
    commanded: list[tuple[int, int, float]],
    braked: list[tuple[int, int, int, float]],
    speed_mps: float,
) -> None:
    """Accelerations change at any millisecond, and vehicles are so slow that they stop."""
    fleet = Fleet(
        scenario(
            speed_mps=speed_mps,
            brakes=tuple(brake(i, at / 1e3, ms / 1e3, a) for i, at, ms, a in braked),
        )
    )
    commanded = sorted(commanded, key=lambda entry: entry[1])
    start = fleet.position.tolist()
    give(fleet, [(i, at * MS_NS, a) for i, at, a in commanded])
    for cycle in range(1, 24):
        assert fleet.advance_to(cycle * T_NS) == []
        assert (fleet.speed >= 0.0).all()
        for i in range(3):
            p, v = exact(
                start[i],
                speed_mps,
                [(at * MS_NS, a) for who, at, a in commanded if who == i + 1],
                [(at * MS_NS, (at + ms) * MS_NS, a) for who, at, ms, a in braked if who == i + 1],
                cycle * T_NS,
            )
            assert fleet.position[i] == pytest.approx(p, abs=1e-9)
            assert fleet.speed[i] == pytest.approx(v, abs=1e-9)
        assert fleet.road.gaps(fleet.position).sum() == pytest.approx(3_000.0, abs=1e-9)


def test_sensed_acceleration_is_the_mean_over_the_cycle() -> None:
    fleet = Fleet(scenario())
    give(fleet, [(1, 25 * MS_NS, 2.0)])
    fleet.advance_to(T_NS)
    assert fleet.mean_acceleration.tolist() == pytest.approx([1.5, 0.0, 0.0], abs=1e-12)
    fleet.advance_to(2 * T_NS)
    assert fleet.mean_acceleration.tolist() == pytest.approx([2.0, 0.0, 0.0], abs=1e-12)


def test_a_command_takes_effect_at_its_time_or_at_once_if_that_has_passed() -> None:
    fleet = Fleet(scenario())
    fleet.advance_to(T_NS)
    give(fleet, [(1, 50 * MS_NS, 1.0), (2, T_NS, 2.0), (3, 2 * T_NS, 3.0)])
    fleet.advance_to(2 * T_NS)
    assert fleet.speed.tolist() == pytest.approx([10.1, 10.2, 10.0], abs=1e-12)
    assert fleet.acceleration.tolist() == [1.0, 2.0, 3.0]
    fleet.advance_to(3 * T_NS)
    assert fleet.speed.tolist() == pytest.approx([10.2, 10.4, 10.3], abs=1e-12)


def test_commands_are_limited_and_brakes_are_not() -> None:
    fleet = Fleet(scenario(brakes=(brake(2, 0.0, 1.0, 8.0), brake(2, 0.0, 2.0, 4.0))))
    give(fleet, [(i, 0, 50.0) for i in (1, 2, 3)])
    fleet.advance_to(1)
    assert fleet.acceleration.tolist() == [3.0, -8.0, 3.0]  # the hardest brake counts
    fleet.advance_to(S_NS)
    assert fleet.acceleration.tolist() == [3.0, -4.0, 3.0]
    fleet.advance_to(2 * S_NS)
    assert fleet.acceleration.tolist() == [3.0, 3.0, 3.0]


@settings(deadline=None, max_examples=60)
@given(
    st.booleans(),
    st.lists(st.lists(st.floats(-9.0, 9.0), min_size=5, max_size=5), min_size=1, max_size=40),
    st.integers(0, 99),
)
def test_no_command_breaks_the_order_on_the_ring(
    ring: bool, cycles: list[list[float]], offset_ms: int
) -> None:
    """With gaps of 6 m at 3 m/s there are collisions in nearly every run."""
    fleet = Fleet(scenario(size=5, gap_m=6.0, speed_mps=3.0, ring=ring))
    for k, accelerations in enumerate(cycles):
        at_ns = k * T_NS + offset_ms * MS_NS
        give(fleet, [(i + 1, at_ns, a) for i, a in enumerate(accelerations)])
        before = fleet.position
        collided = [index for _, index in fleet.advance_to((k + 1) * T_NS)]
        gaps = fleet.road.gaps(fleet.position)
        if ring:
            assert gaps.sum() == pytest.approx(30.0, abs=1e-9)
        gaps = gaps[0 if ring else 1 :]
        assert (gaps >= 5.0 - 1e-8).all()
        assert (fleet.speed >= 0.0).all()
        assert (fleet.position[0 if ring else 1 :] >= before[0 if ring else 1 :] - 1.0).all()
        for i in collided:
            gap = fleet.road.gaps(fleet.position)[i]
            assert gap == pytest.approx(5.0, abs=1e-8)
            assert fleet.speed[i] == fleet.speed[i - 1]


def approach(closing_mps: float) -> tuple[Fleet, list[int]]:
    """Let vehicle 2 of 3 approach vehicle 1, which stands, until it must have arrived."""
    fleet = Fleet(scenario(ring=False, gap_m=8.0, speed_mps=0.0))
    fleet.speed = np.array([0.0, closing_mps, 0.0])
    reported: list[int] = []
    for k in range(1, 5 + round(40.0 / closing_mps)):
        reported += [index for _, index in fleet.advance_to(k * T_NS)]
    return fleet, reported


@pytest.mark.parametrize("closing_mps", [10.0, 3.0, 1.7, 0.5, 0.2])
def test_a_collision_is_reported_at_any_speed(closing_mps: float) -> None:
    fleet, reported = approach(closing_mps)
    assert fleet.position.tolist() == pytest.approx([16.0, 11.0, 0.0], abs=1e-8)
    assert fleet.speed.tolist() == [0.0, 0.0, 0.0]
    assert reported == [1]


def test_each_contact_is_reported_once() -> None:
    fleet, reported = approach(4.0)
    push = [(2, fleet.time_ns, 3.0)]
    give(fleet, push)
    for _ in range(10):  # it pushes on: the same contact
        reported += [index for _, index in fleet.advance_to(fleet.time_ns + T_NS)]
    assert reported == [1]
    assert fleet.position[1] == pytest.approx(11.0, abs=1e-8)
    give(fleet, [(1, fleet.time_ns, 3.0), (2, fleet.time_ns, 0.0)])
    for _ in range(10):  # the one ahead drives off
        reported += [index for _, index in fleet.advance_to(fleet.time_ns + T_NS)]
    give(fleet, [(1, fleet.time_ns, -3.0), (2, fleet.time_ns, 3.0)])
    for _ in range(50):
        reported += [index for _, index in fleet.advance_to(fleet.time_ns + T_NS)]
    assert reported == [1, 1]
