"""The log has an event when a vehicle follows a speed, and its truth follows that speed."""

from __future__ import annotations

import json
from math import pi, sin
from pathlib import Path

import pytest

from tests.conftest import run
from zenvoy.bus import messages_pb2 as pb

S_NS = 1_000_000_000
SCENARIO = """
duration_s: 6
road: {type: open}
fleet: {size: 4}
control: {model: FM}
sensors: {error: 0}
events:
  - {type: brake, vehicle: 3, at_s: 2, duration_s: 1, deceleration_mps2: 1}
  - {type: sine, vehicle: 1, at_s: 1, duration_s: 3, amplitude_mps: 1, frequency_hz: 0.5}
  - {type: trace, vehicle: 1, at_s: 4.05, file: drive.csv}
"""


@pytest.mark.parametrize("bus", ["in-process", "zenoh"])
def test_the_log_has_events_and_truth_of_traces(tmp_path: Path, bus: str) -> None:
    csv = tmp_path / "out"
    csv.mkdir()
    (csv / "drive.csv").write_text("time_s,speed_mps\n0,30\n1,31.5\n")
    scenario = SCENARIO.replace("drive.csv", str(csv / "drive.csv"))
    log = run(tmp_path / "run", scenario, "--bus", bus)
    events = [pb.Event.FromString(message.data) for message in log.of("/events")]
    assert [(e.time_ns / S_NS, e.kind, e.vehicle, e.text) for e in events] == [
        (1.0, pb.EVENT_TRACE, 1, "sine, 30 ± 1 m/s, 0.5 Hz"),
        (2.0, pb.EVENT_BRAKE, 3, "1 m/s²"),
        (3.0, pb.EVENT_BRAKE_END, 3, ""),
        (4.0, pb.EVENT_TRACE_END, 1, ""),
        (4.05, pb.EVENT_TRACE, 1, "trace of 2 points"),
        (5.05, pb.EVENT_TRACE_END, 1, ""),
    ]
    truth = [pb.FleetTruth.FromString(message.data) for message in log.of("/fleet/truth")]
    speed = [row.speed[0] for row in truth]
    for k in range(10, 41):
        assert speed[k] == pytest.approx(30 + sin(pi * (k / 10 - 1.0)), abs=1e-12)
    for k in range(41, 51):
        assert speed[k] == pytest.approx(30 + 1.5 * (k / 10 - 4.05), abs=1e-12)
    assert speed[51:] == [pytest.approx(31.5, abs=1e-12)] * 10  # it keeps its last speed
    values = json.loads(log.attachments["effective.json"])
    assert values["events"][2]["points"] == [[0.0, 30.0], [1.0, 31.5]]
