"""The world's agent keeps absolute deadlines."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fleet.realtime_agents.runs import MS, QUIET, scenario
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.refusals import UNCLOCKED
from zenvoy.bus.topics import COMMAND
from zenvoy.world.realtime import RealtimeWorld


def test_cycles_keep_absolute_deadlines_and_overruns_are_counted(tmp_path: Path) -> None:
    world = RealtimeWorld(scenario(tmp_path, QUIET))
    logged = []
    for cycle, late_ns in enumerate((0, MS, 2 * MS, 350 * MS, 250 * MS, 150 * MS, 50 * MS, 0)):
        if world.due_ns < cycle * 100 * MS:  # late in a cycle, a finished one is logged
            assert world.due_ns == (cycle - 1) * 100 * MS + 75 * MS
            logged += [envelope.topic.logged_as for envelope in world.act(world.due_ns)]
        assert world.due_ns == cycle * 100 * MS
        world.act(world.due_ns + late_ns)
    assert world.overruns == 5
    assert logged[:4] == ["/v2v/frames", "/fleet/estimate", "/fleet/command", "/realtime"]
    assert len(logged) == 5 * 4  # cycles 0 to 4, each after the time of effect of its commands


@pytest.mark.parametrize(("error_ns", "fault"), [(5 * MS, None), (5 * MS + 1, UNCLOCKED)])
def test_commands_of_a_machine_whose_clock_is_known_too_badly_are_refused(
    tmp_path: Path, error_ns: int, fault: str | None
) -> None:
    world = RealtimeWorld(scenario(tmp_path, QUIET + "max_clock_error_ms: 5\n"))
    command = pb.Command(
        time_ns=20 * MS,
        vehicle=1,
        effective_ns=100 * MS,
        mode=pb.MODE_FM,
        age_ns=-1,
        timing=pb.Timing(decided_ns=20 * MS, clock_error_ns=error_ns),
    )
    assert world.fault_in(COMMAND, 1, command) == fault
