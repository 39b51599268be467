"""The acceleration that a vehicle expects under a lag equals that of the world."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.vehicles.commanded import LaggedCommands, commanded
from zenvoy.world.actuators import Actuators

PERIOD_NS = 100_000_000
DELAY_NS = 130_000_000

commands = st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=15)


def moved(lag_s: float, given_commands: list[float], until_ns: int) -> list[float]:
    """Return the true speed at each instant of a change and at the end, from 100 m/s on, m/s."""
    world = Actuators(np.array([lag_s]))
    position, speed = np.zeros(1), np.full(1, 100.0)
    speeds, now_ns, u = [100.0], 0, 0.0
    for number, command in enumerate([*given_commands, 0.0]):
        at_ns = until_ns if number == len(given_commands) else number * PERIOD_NS + DELAY_NS
        dt_s = (at_ns - now_ns) * 1e-9
        position, speed = world.advance(position, speed, np.array([u]), dt_s)
        speeds.append(float(speed[0]))
        now_ns, u = at_ns, command
    return speeds


@given(commands, st.floats(0.05, 2.0))
def test_the_mean_over_a_period_is_the_true_one(values: list[float], lag_s: float) -> None:
    expected = LaggedCommands(lag_s)
    for number, value in enumerate(values):
        expected.command(number * PERIOD_NS + DELAY_NS, value)
    *_, before, after = moved(lag_s, values, (len(values) + 1) * PERIOD_NS + DELAY_NS)
    start_ns = (len(values) - 1) * PERIOD_NS + DELAY_NS
    mean = expected.mean(start_ns, start_ns + 2 * PERIOD_NS)
    assert mean == pytest.approx((after - before) / 0.2, abs=1e-9)


@given(commands, st.floats(0.1, 1.0))
def test_a_plan_leads_to_the_true_speed(values: list[float], lag_s: float) -> None:
    """Within the time in which the plan follows the lag."""
    expected = LaggedCommands(lag_s)
    for number, value in enumerate(values):
        now_ns = number * PERIOD_NS
        expected.steps_from(now_ns)  # as a vehicle does in each cycle
        expected.command(now_ns + DELAY_NS, value)
    now_ns = len(values) * PERIOD_NS
    times, plan = expected.steps_from(now_ns)
    end_ns = times[-1]
    assert end_ns - now_ns >= 2.9e9 * lag_s
    spans_s = np.diff(times) * 1e-9
    true = moved(lag_s, values, end_ns)[-1]
    at_now = expected_speed(lag_s, values, now_ns)
    assert at_now + float(spans_s @ np.array(plan[:-1])) == pytest.approx(true, abs=1e-6)
    assert plan[-1] == values[-1]


def expected_speed(lag_s: float, values: list[float], now_ns: int) -> float:
    """Return the true speed at an instant, when not all commands have taken effect."""
    in_force = [v for n, v in enumerate(values) if n * PERIOD_NS + DELAY_NS < now_ns]
    return moved(lag_s, in_force, now_ns)[-1]


def test_a_reading_that_contradicts_is_where_the_lag_goes_on_from() -> None:
    expected = LaggedCommands(0.5)
    expected.restart(0, -6.0)
    assert expected.mean(0, 500_000_000) == pytest.approx(-6.0 * (1.0 - np.exp(-1.0)))


def test_without_a_lag_commands_act_at_once() -> None:
    expected = commanded(0.0, 10 * PERIOD_NS)
    expected.command(PERIOD_NS, 2.0)
    assert expected.mean(0, 2 * PERIOD_NS) == 1.0
    assert expected.steps_from(0) == ([0, PERIOD_NS], [0.0, 2.0])
