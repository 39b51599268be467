"""In real time too, the scenario kills processes, freezes them, and starts new ones."""

from __future__ import annotations

from pathlib import Path

from tests.conftest import run, zenvoy
from tests.streamed_log import read_log
from zenvoy.bus import messages_pb2 as pb

RESTARTED = """
duration_s: 6
clock: realtime
on_vehicle_loss: restart
fleet: {size: 4}
control: {v2v_wait_ms: 50, system_delay_ms: 60}
faults:
  - {type: process-killed, vehicles: 3, at_s: 1, duration_s: 2}
  - {type: process-frozen, vehicles: 2, at_s: 1, duration_s: 2}
"""
LOST = """
duration_s: 6
clock: realtime
fleet: {size: 4}
control: {v2v_wait_ms: 50, system_delay_ms: 60}
faults: [{type: process-killed, vehicles: 3, at_s: 1}]
"""


def test_a_killed_process_is_replaced_and_a_frozen_one_goes_on(tmp_path: Path) -> None:
    log = run(tmp_path / "run", RESTARTED)
    assert (log.result["end"], log.result["cycles"]) == ("complete", "60")
    logs = sorted(path.name for path in (tmp_path / "run" / "out" / "logs").glob("vehicle-*"))
    assert logs == [f"vehicle-0{one}.log" for one in ("1", "2", "3-2", "3", "4")]
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    came = [row.commanded_ns for row in rows]
    assert all(row[vehicle] == -1 for row in came[10:30] for vehicle in (1, 2))
    assert any(row[2] >= 0 for row in came[:10])
    for vehicle in (1, 2):  # both are back, unless the machine holds them up for three seconds
        assert any(row[vehicle] >= 0 for row in came[30:])
    events = [pb.Event.FromString(message.data) for message in log.of("/events")]
    told = [event.text for event in events if event.kind == pb.EVENT_FAULT]
    assert sorted(told) == ["process frozen", "process killed"]
    lost = [event.text for event in events if event.kind == pb.EVENT_PROCESS_LOST]
    back = [event.text for event in events if event.kind == pb.EVENT_PROCESS_BACK]
    assert lost[:1] == back[:1] == ["vehicle-03"]


def test_a_run_ends_with_its_vehicle_unless_told_otherwise(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(LOST)
    outcome = zenvoy(tmp_path, "run", "s.yaml", "--out", "out")
    assert outcome.code == 3
    assert "vehicle-03 died: killed by a fault of the scenario at 1 s" in outcome.err
    log = read_log(tmp_path / "out" / "run.mcap")
    assert log.whole
    events = [pb.Event.FromString(message.data) for message in log.of("/events")]
    (stopped,) = [event for event in events if event.kind == pb.EVENT_STOPPED]
    assert (stopped.text, stopped.time_ns) == ("vehicle-03 killed", 1_000_000_000)
