"""Vehicles with lags plan the same on arrays as one by one, in every bit."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Control, Scenario
from zenvoy.vehicles.arrays.own import OwnMotion
from zenvoy.vehicles.arrays.plans import Stretch
from zenvoy.vehicles.arrays.rows import ALL
from zenvoy.vehicles.arrays.timing import Timing
from zenvoy.vehicles.control import FOLLOWING
from zenvoy.vehicles.knowledge import Knowledge
from zenvoy.vehicles.motion import Motion
from zenvoy.vehicles.neighbours import neighbours

COUNT: Final = 4
PERIOD_NS: Final = 20_000_000
KEEP_NS: Final = 10**12


class Cycle(NamedTuple):
    """Commands, by how much readings differ from the plans, and a stretch of time to plan, ns."""

    commands: list[float]
    errors: list[float]
    from_ns: int
    length_ns: int


def of_each(values: st.SearchStrategy[float]) -> st.SearchStrategy[list[float]]:
    return st.lists(values, min_size=COUNT, max_size=COUNT)


CYCLES: Final = st.lists(
    st.builds(
        Cycle,
        of_each(st.floats(-6.0, 6.0, allow_subnormal=False)),
        of_each(st.sampled_from([0.0, 0.0, 0.0, 0.05, 2.0])),
        st.integers(0, 2 * 10**9),
        st.integers(0, 2 * 10**9),
    ),
    min_size=1,
    max_size=12,
)


class Alone:
    """One vehicle, and what another one learns from its beacons."""

    def __init__(self, scenario: Scenario, lag_s: float) -> None:
        near = neighbours(scenario, 2, [FOLLOWING])
        self.known = Knowledge(scenario, near, estimates=False, lag_s=lag_s)
        self.own, self.heard = Motion(KEEP_NS), Motion(KEEP_NS)
        self.plan: list[float] = []

    def sense(self, number: int, reading: float) -> None:
        time_ns = number * PERIOD_NS
        sense = pb.Sense(cycle=number, time_ns=time_ns, acceleration=reading)
        times, self.plan = self.known.sense(sense)
        for motion in (self.own, self.heard):
            motion.learn(time_ns - PERIOD_NS, time_ns, reading, times, self.plan)


def row(pair: Any, at: int) -> tuple[float, float]:
    """Return displacement and change of speed of one vehicle."""
    dp, dv = (float(np.broadcast_to(values, COUNT)[at]) for values in pair)
    return dp, dv


@given(
    of_each(st.sampled_from([0.0, 0.001, 0.1, 0.5, 3.0])),
    CYCLES,
    st.sampled_from([0.0, 11.0]),
    st.one_of(st.sampled_from([0.0, 9.0, 20.0, 89.0]), st.floats(0.0, 150.0)),
    st.integers(0, 4),
)
def test_plans_are_those_of_single_vehicles(
    lag_s: list[float], cycles: list[Cycle], wait_ms: float, delay_ms: float, back: int
) -> None:
    control = Control(v2v_wait_ms=wait_ms, system_delay_ms=delay_ms)
    scenario = Scenario(period_ms=PERIOD_NS * 1e-6, control=control)
    timing = Timing.of(scenario)
    alone = [Alone(scenario, lag) for lag in lag_s]
    together, first = (
        OwnMotion(timing, np.array(lag_s), predicts=predicts) for predicts in (True, False)
    )
    for number, cycle in enumerate(cycles):
        readings = np.add([one.plan[0] if one.plan else 0.0 for one in alone], cycle.errors)
        until_ns, now_ns = cycle.from_ns + cycle.length_ns, number * PERIOD_NS
        begin = max(0, number - back)
        planned = together.sense(readings).over(timing.starts_ns, Stretch(cycle.from_ns, until_ns))
        moved = together.over(begin, until_ns, ALL)
        in_force = first.sense(readings).values[0]
        for at, (one, reading) in enumerate(zip(alone, readings.tolist(), strict=True)):
            one.sense(number, reading)
            assert in_force[at] == one.plan[0]
            assert together.newest_command[at] == one.known.newest_command
            assert row(planned, at) == one.heard.over(now_ns + cycle.from_ns, now_ns + until_ns)
            assert row(moved, at) == one.own.over(begin * PERIOD_NS, now_ns + until_ns)
            one.known.command(now_ns + timing.effect_ns, cycle.commands[at])
        for motion in (together, first):
            motion.command(np.array(cycle.commands))
