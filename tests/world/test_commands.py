"""Commands that are read together are those that would be read one by one."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.checks import fault_in_timing
from zenvoy.bus.topics import COMMAND
from zenvoy.scenarios import Control, Fleet, Scenario
from zenvoy.world.commands import CommandReader, Commands
from zenvoy.world.lock_step import LockStepWorld
from zenvoy.world.realtime import RealtimeWorld
from zenvoy.world.timings import Timings

MS = 1_000_000
SCENARIO = Scenario(
    fleet=Fleet(size=3), control=Control(model="FM"), clock="realtime", max_clock_error_ms=5.0
)
DECIDED_NS = SCENARIO.v2v_wait_ns
EFFECTIVE_NS = DECIDED_NS + SCENARIO.system_delay_ns


@st.composite
def commands(draw: st.DrawFn) -> pb.Command:
    """Draw a command of vehicle 1 to 3 for cycle 0, nearly always a good one."""

    def mostly(good: Any, *bad: Any) -> Any:
        return draw(st.sampled_from([*[good] * 30, *bad]))

    command = pb.Command(
        cycle=mostly(0, 1),
        time_ns=DECIDED_NS + mostly(0, 1),
        vehicle=draw(st.integers(1, 3)),
        effective_ns=EFFECTIVE_NS + mostly(0, 1),
        acceleration=mostly(draw(st.floats(-3.0, 3.0)), nan, inf),
        mode=mostly(pb.MODE_FM, 77, 200),
        age_ns=-1,
        logged=draw(st.lists(st.floats(0.0, 9.0), max_size=3)),
    )
    command.ahead.gap = draw(st.floats(1.0, 9.0))
    if draw(st.booleans()):
        command.timing.sensed_ns = draw(st.integers(1, 9))
        frames = draw(st.integers(0, 3))
        command.timing.source.extend([mostly(2, 0, 4)] * frames)
        command.timing.arrived_ns.extend([5] * mostly(frames, 3))
        command.timing.came_ns.extend([6] * mostly(frames, 2))
        command.timing.clock_error_ns = mostly(1 * MS, -1, 6 * MS)
    return command


def columns_of(read: Commands) -> tuple[list[Any], ...]:
    """Return commands and their timing, to be compared."""
    timings = Timings(3)
    timings.put(read, np.full(len(read.rows), 9))
    times = [column.tolist() for column in timings.times.values()]
    # Rows as bytes, because NaN is not equal to itself.
    rows = [read.rows.tobytes(), read.logged.tobytes(), timings.frames.tolist()]
    return rows, times, [timings.commanded_ns.tolist()]


FLEETS = st.lists(commands(), min_size=1, max_size=3, unique_by=lambda one: one.vehicle)


@given(FLEETS, st.booleans())
def test_they_are_read_together_unless_one_would_be_refused(
    given_commands: list[pb.Command], realtime: bool
) -> None:
    world: LockStepWorld | RealtimeWorld
    world = RealtimeWorld(SCENARIO) if realtime else LockStepWorld(SCENARIO)
    if isinstance(world, RealtimeWorld):
        world.act(0)  # cycle 0 begins
    parcels = [(one.vehicle, one.SerializeToString()) for one in given_commands]
    found = world.joint_decoders[COMMAND](parcels)
    refused = any(world.fault_in(COMMAND, one.vehicle, one) for one in given_commands)
    cycles = {one.cycle for one in given_commands}
    begun = not realtime or cycles == {0}
    assert (found is not None) == (not refused and len(cycles) == 1 and begun)


@given(FLEETS)
def test_columns_are_those_of_the_messages(given_commands: list[pb.Command]) -> None:
    sound = [one for one in given_commands if fault_in_timing(one.timing, 3) is None]
    sound = [one for one in sound if one.mode < 128]
    assume(sound)
    reader = CommandReader(2)
    together = reader.flat([one.SerializeToString() for one in sound])
    # An unknown field at the end is nothing that columns hold, so these are read one by one.
    one_by_one = reader.read([one.SerializeToString() + b"\xa0\x06\x01" for one in sound])
    assert together is not None
    assert not one_by_one.alike
    assert one_by_one.rows["ahead_gap"].tolist() == [one.ahead.gap for one in sound]
    for mine, its in zip(columns_of(together), columns_of(one_by_one), strict=True):
        assert mine == its
