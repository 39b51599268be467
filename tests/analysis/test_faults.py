"""Reports say what faults cost, from the log alone."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.faults import faults_section
from zenvoy.analysis.measures.faults import FaultSpan, Moves, costs, fault_spans
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.happenings import Happening, happenings
from zenvoy.bus import messages_pb2 as pb

SCENARIO = """
duration_s: 20
fleet: {size: 5}
sensors: {error: 0}
faults:
  - {type: actuator-stuck, vehicles: 3-4, at_s: 5, duration_s: 2, acceleration_mps2: -1}
  - {type: transmitter-silent, vehicles: 2, at_s: 16}
"""


def event(at_s: float, kind: pb.EventKind.ValueType, vehicle: int, text: str = "stuck") -> pb.Event:
    return pb.Event(time_ns=round(at_s * 1e9), kind=kind, vehicle=vehicle, text=text)


def test_events_of_one_fault_are_put_together() -> None:
    begin, end = pb.EVENT_FAULT, pb.EVENT_FAULT_END
    events = [
        event(1, begin, 2),
        event(1, begin, 3),
        event(1, begin, 5, "blind"),
        event(4, end, 2),
        event(4, end, 3),
        event(6, begin, 2),
    ]
    assert fault_spans(events) == [
        FaultSpan("stuck", (2, 3), 1.0, 4.0),
        FaultSpan("blind", (5,), 1.0, math.inf),
        FaultSpan("stuck", (2,), 6.0, math.inf),
    ]


def test_the_cost_of_a_brake_by_hand() -> None:
    """On an open road vehicle 1 brakes with 1 m/s² from 20 s to 25 s; vehicle 2 drives on.

    Its gap is 100 m before. At 25 s it is 100 m - 12.5 m, and closes with 5 m/s from there on, for
    10 s: 37.5 m, of which 5 m are vehicle 1.
    """
    time_s = np.arange(0.0, 60.1, 0.1)
    braked_s = np.clip(time_s - 20.0, 0.0, 5.0)
    lost_m = 0.5 * braked_s**2 + 5.0 * np.clip(time_s - 25.0, 0.0, None)
    position = np.stack([30.0 * time_s - lost_m, 30.0 * time_s - 100.0], axis=1)
    speed = np.stack([30.0 - braked_s, np.full(len(time_s), 30.0)], axis=1)
    events = [
        event(20, pb.EVENT_FAULT, 1),
        event(25, pb.EVENT_FAULT_END, 1),
        event(30, pb.EVENT_COLLISION, 2),
        event(36, pb.EVENT_COLLISION, 2),  # too late to count
    ]
    (cost,) = costs(events, Moves(time_s, position, speed, 5.0, None))
    assert cost.before is not None
    assert cost.before.gap_m == pytest.approx(100.0)
    assert cost.before.collision_time_s == math.inf
    assert (cost.before.slower_mps, cost.before.collisions) == (0.0, 0)
    during = cost.during
    assert during.gap_m == pytest.approx(37.5)
    assert during.vehicle == 2
    assert during.collision_time_s == pytest.approx((37.5 - 5.0) / 5.0)
    assert during.slower_mps == pytest.approx(5.0)
    assert during.collisions == 1


def test_a_report_has_a_chapter_with_table_and_picture(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "run.mcap", SCENARIO))
    section = faults_section(run)
    assert section is not None
    assert "Faults" in [chapter.title for chapter in chapters(run)]
    (sheet,) = section.sheets
    rows = [dict(zip(sheet.columns, row, strict=True)) for row in sheet.rows]
    first, second = rows
    assert (first["from, s"], first["to, s"], first["vehicles"]) == (5.0, 7.0, "3-4")
    assert (second["to, s"], second["fault"]) == (None, "transmitter silent")
    assert float(str(first["largest loss of speed, m/s"])) >= 2.0  # 1 m/s² for 2 s
    assert first["before: loss of speed, m/s"] == pytest.approx(0.0, abs=1e-6)
    (picture,) = section.pictures
    assert drawn(picture).png
    found = [one for one in happenings(run) if one.kind == "fault"]
    assert found == [
        Happening("fault", 5.0, 7.0, "fault of vehicles 3-4: actuator stuck at -1 m/s²"),
        Happening("fault", 16.0, math.inf, "fault of vehicle 2: transmitter silent"),
    ]


def test_a_run_without_faults_has_no_chapter(tmp_path: Path) -> None:
    text = SCENARIO[: SCENARIO.index("faults:")].replace("20", "2")
    assert faults_section(load(write_log(tmp_path / "run.mcap", text))) is None
