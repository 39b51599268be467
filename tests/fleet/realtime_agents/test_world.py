"""The world's agent keeps absolute deadlines."""

from __future__ import annotations

from pathlib import Path

from tests.fleet.realtime_agents.runs import MS, QUIET, scenario
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
