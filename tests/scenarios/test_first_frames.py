"""A vehicle that has not heard anybody yet has not fallen back to FM."""

from __future__ import annotations

import json
from pathlib import Path

from tests.conftest import zenvoy
from tests.scenarios.conftest import Write
from zenvoy.analysis import load as load_log
from zenvoy.analysis.measures.fallbacks import fallbacks
from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario


def event(kind: pb.EventKind.ValueType, vehicle: int, at_s: float) -> pb.Event:
    return pb.Event(kind=kind, vehicle=vehicle, time_ns=round(at_s * 1e9))


def test_a_vehicle_that_has_heard_nobody_yet_has_not_fallen_back() -> None:
    falls, ends = pb.EVENT_FALLBACK, pb.EVENT_FALLBACK_END
    events = [
        event(falls, 1, 0.011),  # until the first frame comes
        event(falls, 2, 0.011),  # for longer than data are valid
        event(falls, 3, 0.011),  # for good
        event(ends, 1, 0.211),
        event(ends, 2, 1.111),
        event(falls, 1, 5.011),
        event(ends, 1, 5.111),
    ]
    assert fallbacks(events, Scenario()) == 3
    assert fallbacks(events[:1], Scenario()) == 1


def test_a_run_over_a_late_channel_starts_without_fallbacks(write: Write, tmp_path: Path) -> None:
    write("duration_s: 3\nfleet: {size: 4}\nchannel: {technology: lte-a-pro}\n")
    command = ("run", "s.yaml", "--bus", "in-process", "--set", "control.v2v_wait_ms=0")
    assert zenvoy(tmp_path, *command, "--out", "r").code == 0
    run = load_log("r/run.mcap")
    assert any(found.kind == pb.EVENT_FALLBACK for found in run.events)
    assert json.loads(Path("r/summary.json").read_text())["fallbacks"] == 0
