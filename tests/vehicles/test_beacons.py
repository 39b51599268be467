"""A vehicle's beacons have its readings and its planned accelerations."""

from __future__ import annotations

import pytest

from tests.cab import EGO, T_NS, Cab, assert_plans, scenario
from zenvoy.scenarios import Gains


def test_a_beacon_has_the_readings() -> None:
    cab = Cab(scenario())
    cab.sense()
    cab.receive()
    sent = cab.sense(gap=31.0, relative_speed=-1.5, speed=28.0, acceleration=0.05)
    assert (sent.vehicle, sent.cycle, sent.sequence, sent.time_ns) == (EGO, 1, 1, T_NS)
    assert (sent.position, sent.speed, sent.acceleration) == (1_000.0, 28.0, 0.05)
    assert (sent.ahead.gap, sent.ahead.speed) == (31.0, -1.5)
    assert not Cab(scenario(open_road=True), 1).sense(gap=None).HasField("ahead")


def test_a_beacon_has_the_commands_that_are_not_yet_in_effect() -> None:
    """A command is decided at 11 ms and takes effect at 280 ms, so three are pending at once."""
    cab = Cab(scenario(model="FM", wait_ms=11, delay_ms=269))
    decided: list[float] = []
    for cycle in range(8):
        # In the cycle before, one command acted for 80 ms, then the next for 20 ms.
        older = decided[cycle - 4] if cycle >= 4 else 0.0
        newer = decided[cycle - 3] if cycle >= 3 else 0.0
        sent = cab.sense(gap=40.0 + cycle, acceleration=0.8 * older + 0.2 * newer)
        on_the_way = [(100 * k + 280, decided[k]) for k in range(max(0, cycle - 2), cycle)]
        in_force = decided[cycle - 3] if cycle >= 3 else 0.0
        assert_plans(sent, (100 * cycle, in_force), *on_the_way)
        command = cab.receive()
        assert command.effective_ns == cycle * T_NS + 280_000_000
        decided.append(command.acceleration)
    assert len(set(decided)) == 8


@pytest.mark.parametrize("read", [-3.0, 0.2, 2.0])
def test_a_reading_that_contradicts_the_commands_replaces_the_plan(read: float) -> None:
    cab = Cab(scenario(model="FM", delay_ms=189, gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    for _ in range(4):
        cab.sense(gap=42.5)
        assert cab.receive().acceleration == pytest.approx(0.5)
    sent = cab.sense(gap=42.5, acceleration=read)
    assert_plans(sent, (400, read))
    cab.receive()
    sent = cab.sense(gap=42.5, acceleration=0.5)  # as commanded again
    assert_plans(sent, (500, 0.5), (600, 0.5))


def test_a_reading_close_to_the_command_keeps_the_plan() -> None:
    cab = Cab(scenario(model="FM", gains=Gains(k_d=0.1, k_v=0.0, k_c=0.0)))
    cab.sense(gap=42.5)
    cab.receive()
    cab.sense(gap=42.5)
    cab.receive()
    assert_plans(cab.sense(acceleration=0.42), (200, 0.5))
