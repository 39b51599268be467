"""Commands in real time count alike, whether they come alone or together."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from zenvoy.bus import messages_pb2 as pb
from zenvoy.world.commands import CommandReader, FleetCommands
from zenvoy.world.realtime_commands import CycleCommands, RealtimeCommands
from zenvoy.world.timings import Timings

SIZE = 4
TIMES = st.lists(st.integers(0, 20), min_size=SIZE, max_size=SIZE)


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
    effective_ns=TIMES,
    alone_ns=TIMES,
    together=st.sets(st.integers(1, SIZE)),
    flat=st.booleans(),
    cycle_begins_between=st.booleans(),
)
def test_a_command_counts_from_its_arrival_on_however_it_comes(
    effective_ns: list[int],
    alone_ns: list[int],
    together: set[int],
    flat: bool,
    cycle_begins_between: bool,
) -> None:
    reader, together_ns = CommandReader(1), 10
    came_ns = {n: together_ns if n in together else alone_ns[n - 1] for n in range(1, SIZE + 1)}
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
            commands.keep(arrived, 7)

    if together:
        commands.wait_together(reader.read([those[n] for n in sorted(together)]), together_ns)
    if cycle_begins_between:
        begin_cycle()
    for n in {*those} - together:
        assert commands.are_newer((n,), 7)
        commands.wait(n, 7, those[n] + (unknown if n % 2 else b""), came_ns[n])
        assert not commands.are_newer((1, n), 7)
    begin_cycle()
    begin_cycle()  # nothing is left
    assert effective == {n: max(at_ns, came_ns[n]) for n, at_ns in enumerate(effective_ns, start=1)}
    alone = RealtimeCommands(SIZE, reader, lambda: FleetCommands(SIZE, 1))
    for n, payload in those.items():
        alone.wait(n, 7, payload, came_ns[n])
        for arrived in alone.arrived():
            alone.keep(arrived, 0)
    assert columns_of(commands.take_out(7)) == columns_of(alone.take_out(7))
    assert not commands.take_out(7).fleet.there.any()


def test_commands_of_a_cycle_that_is_logged_are_not_kept() -> None:
    commands = RealtimeCommands(SIZE, CommandReader(1), lambda: FleetCommands(SIZE, 1))
    commands.wait(1, 7, command(1, 0).SerializeToString(), 10)
    (arrived,) = commands.arrived()
    commands.keep(arrived, 8)
    assert not commands.parts(7)
    assert not commands.take_out(7).fleet.there.any()
