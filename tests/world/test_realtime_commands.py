"""Commands in real time count alike, whether they come alone or together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fleet.realtime_agents.one_agent import post
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.frame_table import FRAME_COLUMNS, FRAMES_CODEC
from zenvoy.bus.topics import COMMAND, FRAMES, LINKS
from zenvoy.scenarios import Control, Fleet, Scenario
from zenvoy.world.commands import CommandReader, FleetCommands
from zenvoy.world.realtime import RealtimeWorld
from zenvoy.world.realtime_commands import CycleCommands, RealtimeCommands
from zenvoy.world.timings import Timings

SIZE, MS = 4, 1_000_000


def command(vehicle: int, effective_ns: int) -> pb.Command:
    timing = pb.Timing(sensed_ns=vehicle, source=[1], arrived_ns=[2], came_ns=[vehicle])
    return pb.Command(
        cycle=7, vehicle=vehicle, effective_ns=effective_ns, logged=[vehicle], timing=timing
    )


def columns_of(found: CycleCommands) -> list[list[object]]:
    """Return commands and their timing, to be compared."""
    timings = Timings(SIZE)
    for part in found.parts:
        timings.put(*part)
    fleet = found.fleet
    columns = [fleet.rows[name] for name in ("vehicle", "effective_ns", "acceleration")]
    columns += [fleet.logged, fleet.there, timings.commanded_ns, *timings.times.values()]
    return [np.nan_to_num(column).tolist() for column in columns] + [timings.frames.tolist()]


@given(
    effective_ns=st.lists(st.integers(0, 20), min_size=SIZE, max_size=SIZE),
    together=st.sets(st.integers(1, SIZE)),
    flat=st.booleans(),
    cycle_begins_between=st.booleans(),
)
def test_a_command_counts_from_its_arrival_on_however_it_comes(
    effective_ns: list[int], together: set[int], flat: bool, cycle_begins_between: bool
) -> None:
    reader, came_ns = CommandReader(1), 10
    unknown = b"" if flat else b"\xa0\x06\x01"  # a message with this field is read by protobuf
    those = {n: command(n, effective_ns[n - 1]).SerializeToString() for n in range(1, SIZE + 1)}
    commands = RealtimeCommands(SIZE, reader, lambda: FleetCommands(SIZE, 1))
    effective: dict[int, int] = {}

    def begin_cycle() -> None:
        for arrived in commands.arrived():
            rows = arrived.commands.rows
            effective.update(
                zip(rows["vehicle"].tolist(), rows["effective_ns"].tolist(), strict=True)
            )
            commands.keep(arrived)

    if together:
        commands.wait_together(reader.read([those[n] for n in sorted(together)]), came_ns)
    if cycle_begins_between:
        begin_cycle()
    for n in {*those} - together:
        assert commands.are_newer((n,), 7)
        commands.wait(n, 7, those[n] + unknown, came_ns)
        assert not commands.are_newer((1, n), 7)
    begin_cycle()
    begin_cycle()  # nothing is left
    assert effective == {n: max(at_ns, came_ns) for n, at_ns in enumerate(effective_ns, start=1)}
    alone = RealtimeCommands(SIZE, reader, lambda: FleetCommands(SIZE, 1))
    alone.wait_together(reader.read(list(those.values())), came_ns)
    for arrived in alone.arrived():
        alone.keep(arrived)
    assert columns_of(commands.take_out(7)) == columns_of(alone.take_out(7))
    assert not commands.take_out(7).fleet.there.any()


@pytest.mark.parametrize(
    ("came_ns", "outcome"), [(290 * MS, pb.OUTCOME_DELIVERED), (310 * MS, pb.OUTCOME_LATE)]
)
def test_a_report_counts_if_it_comes_before_the_cycle_ends(
    came_ns: int, outcome: pb.Outcome.ValueType
) -> None:
    """It must not matter when the log is written, which is after that."""
    control = Control(model="FM", v2v_wait_ms=0.0, system_delay_ms=60.0)
    world = RealtimeWorld(Scenario(fleet=Fleet(size=2), control=control, clock="realtime"))
    columns = {name: [0] for name in FRAME_COLUMNS} | {
        "source": [2],
        "destination": [1],
        "arrived_ns": [50 * MS],
        "outcome": [pb.OUTCOME_DELIVERED],
    }
    links = pb.Links(frames=FRAMES_CODEC.encode(cycle=0, time_ns=0, **columns))
    report = pb.Command(cycle=1, time_ns=100 * MS, vehicle=1, effective_ns=160 * MS)
    report.timing.source.append(2)
    report.timing.arrived_ns.append(50 * MS)
    report.timing.came_ns.append(50 * MS)
    logged = None
    for time_ns in (*range(0, 400, 100), 375):  # cycle 0 ends with the fourth, and is logged
        if time_ns * MS > came_ns and report.cycle:
            assert world.take_in(post(COMMAND, 1, came_ns, report)) is None
            report = pb.Command()
        assert world.due_ns == time_ns * MS
        logged = world.act(world.due_ns)
        if time_ns == 0:
            assert world.take_in(post(LINKS, 0, 60 * MS, links)) is None
    assert logged is not None
    (frames,) = (one.payload for one in logged if one.topic is FRAMES)
    assert pb.Frames.FromString(frames).outcome == [outcome]
