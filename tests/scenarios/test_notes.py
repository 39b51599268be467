"""Probable mistakes get notes before a run and in its log, and are refused with --strict."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.conftest import zenvoy
from tests.scenarios.conftest import Write
from zenvoy.analysis import load as load_log
from zenvoy.scenarios import load
from zenvoy.scenarios.reading.library import packaged

OPEN = "duration_s: 60\nroad: {type: open}\nfleet: {size: 4}\n"


def notes(*, duration_s: float | None = None) -> list[str]:
    return [str(note) for note in load("s.yaml", duration_s=duration_s).notes]


@pytest.mark.parametrize("name", packaged())
def test_built_in_scenarios_have_no_notes(name: str) -> None:
    assert load(name).notes == ()


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (
            "duration_s: 60\nevents: [{vehicle: 1, at_s: 60, duration_s: 1, deceleration_mps2: 1}]",
            "events.0.at_s: begins at 60 s, but the run ends at 60 s  (s.yaml, line 2)",
        ),
        (
            "duration_s: 60\ncontrol: {schedule: [{at_s: 61, model: FM}]}",
            "control.schedule.0.at_s: 61 is not before the end of the run (60 s)  (s.yaml, line 2)",
        ),
        (
            "control:\n  schedule: [{at_s: 9, model: BCM}, {at_s: 9.5, desired_gap_m: 40}]\n"
            "  model: FM",
            "control.schedule.1.desired_gap_m: 40 has no effect: no law uses it from then on"
            "  (s.yaml, line 2)",
        ),
        (
            "duration_s: 60\nchannel: {outages: [{from_s: 100}]}",
            "channel.outages.0.from_s: 100 is not before the end of the run (60 s)"
            "  (s.yaml, line 2)",
        ),
        (
            "duration_s: 60\nchannel: {rules: [{from_s: 100, loss: {p: 1}}]}",
            "channel.rules.0.from_s: 100 is not before the end of the run (60 s)  (s.yaml, line 2)",
        ),
        (
            "channel: {rules: [{from_s: 1}]}",
            "channel.rules.0: sets neither loss nor latency, so it has no effect  (s.yaml, line 1)",
        ),
        (
            "channel: {outages: [{from_m: 1600, to_m: 1700}]}",
            "channel.outages.0: no vehicle is ever on this stretch; vehicles are from "
            "0 m to 1500 m along the road  (s.yaml, line 1)",
        ),
        (
            OPEN + "channel: {outages: [{from_m: 1913}]}",
            "channel.outages.0: no vehicle is ever on this stretch; vehicles are from "
            "0 m to 1912.5 m along the road  (s.yaml, line 4)",
        ),
        (
            OPEN + "channel: {outages: [{to_m: -1}]}",
            "channel.outages.0: no vehicle is ever on this stretch; vehicles are from "
            "0 m to 1912.5 m along the road  (s.yaml, line 4)",
        ),
        (
            "channel: {outages: [{source: 3, destination: 3}]}",
            "channel.outages.0: covers no link: no vehicle in source sends to another one in "
            "destination  (s.yaml, line 1)",
        ),
        (
            "fleet: {groups: [{name: few, share: 1%}]}",
            "fleet.groups.0.share: none of the 40 vehicles is in this group  (s.yaml, line 1)",
        ),
        (
            "fleet: {gap_m: 9}",
            "control.desired_gap_m: 37.5 is not fleet.gap_m (9), at which the fleet starts, and "
            "which the ring keeps on average  (s.yaml, line 1)",
        ),
        (
            OPEN + "control: {desired_gap_m: 20}",
            "control.desired_gap_m: 20 is not fleet.gap_m (37.5), at which the fleet starts"
            "  (s.yaml, line 4)",
        ),
        (
            OPEN + "control: {desired_speed_mps: 20}",
            "control.desired_speed_mps: 20 is not fleet.speed_mps (30), which the first vehicle "
            "keeps  (s.yaml, line 4)",
        ),
        (
            OPEN
            + "events: [{type: trace, vehicle: 1, at_s: 1, points: [[0, 0], [1, 0.02], [9, 5]]}]",
            "events.0.points: needs -30 m/s² in its first 1 s, because the vehicle has about "
            "30 m/s at its start instead of 0; this is more than "
            "control.acceleration_limit_mps2 (3)  (s.yaml, line 4)",
        ),
        (
            OPEN + "events: [{type: trace, vehicle: 1, at_s: 1, points: [[0, 27], [9, 25]]}]",
            "events.0.points: the speed misses its first point, 27 m/s: the vehicle has about "
            "30 m/s then  (s.yaml, line 4)",
        ),
        (
            OPEN
            + "events: [{type: trace, vehicle: 1, at_s: 1, points: [[0, 30], [9, 30], [10, 25]]}]",
            "events.0.points: needs -5 m/s² at 10 s, more than "
            "control.acceleration_limit_mps2 (3)  (s.yaml, line 4)",
        ),
        (
            OPEN
            + "events: [{type: trace, vehicle: 1, at_s: 0, points: [[43200, 30], [43300, 25]]}]",
            "events.0.at_s: begins at 43200 s, but the run ends at 60 s: its times begin at 43200; "
            "time: from-first counts the times of a file from 0  (s.yaml, line 4)",
        ),
        (
            OPEN + "events: [{type: sine, vehicle: 1, at_s: 1, duration_s: 9, mean_mps: 30, "
            "amplitude_mps: 2, frequency_hz: 0.5}]",
            "events.0.amplitude_mps: needs 6.28 m/s² at 1 s, more than "
            "control.acceleration_limit_mps2 (3)  (s.yaml, line 4)",
        ),
        (
            "channel: {technology: lte-a-pro}\ncontrol: {v2v_wait_ms: 11}",
            "control.v2v_wait_ms: 11 ms is less than the least latency (20.001 ms): every frame "
            "is late, and counts in a later cycle; null, the default, gives 81 ms"
            "  (s.yaml, line 2)",
        ),
        (
            "channel: {latency: {distribution: fixed, mean_ms: 60}}",
            "control.v2v_wait_ms: 11 ms is less than the least latency (60.4 ms): every frame "
            "is late, and counts in a later cycle  (s.yaml, line 1)",
        ),
        (
            "channel: {latency: {distribution: fixed, mean_ms: 160}}\ncontrol: {v2v_wait_ms: 0}",
            "channel.latency: a period (100 ms) is less than the least latency (160.4 ms): every "
            "frame is late, and counts in a later cycle  (s.yaml, line 1)",
        ),
        (
            "clock: realtime\ncontrol: {v2v_wait_ms: 11}",
            "control.v2v_wait_ms: 11 ms leaves 0.6 ms of wall time after the first frames: in real "
            "time most of them miss their decision; null, the default, gives 26 ms"
            "  (s.yaml, line 2)",
        ),
        (
            "fleet: {gap_m: 60}\ncontrol: {desired_gap_m: 60}\nchannel: {technology: 5g-mmwave}",
            "channel.technology: a range of 50 m is less than fleet.gap_m (60): at the start "
            "no frame is received  (s.yaml, line 3)",
        ),
        (
            "beacons: {rule: every-nth, every: 20}",
            "control.beacon_age_limit_ms: 1000 is less than the age of data when the next "
            "beacon arrives (1900 ms): vehicles fall back again and again  (s.yaml, line 1)",
        ),
        (
            "beacons: {period_ms: 1500}",
            "control.beacon_age_limit_ms: 1000 is less than the age of data when the next "
            "beacon arrives (1400 ms): vehicles fall back again and again  (s.yaml, line 1)",
        ),
    ],
)
def test_each_kind_of_note(write: Write, text: str, note: str) -> None:
    write(text)
    assert notes() == [note]


@pytest.mark.parametrize(
    "text",
    [
        "duration_s: 60\nevents: [{vehicle: 1, at_s: 59.9, duration_s: 9, deceleration_mps2: 9}]",
        "channel: {outages: [{from_m: 1400, to_m: 100}, {to_m: 0}, {from_m: 1499}]}",
        OPEN + "channel: {outages: [{from_m: 1912}, {to_m: 0}]}",
        "channel: {rules: [{source: 7, destination: not 7, "
        "latency: {distribution: fixed, mean_ms: 60}}]}",
        "control: {v2v_wait_ms: 0}",
        "clock: realtime\n",
        "clock: realtime\nchannel: {technology: lte-a-pro}\n",
        "channel: {technology: lte-a-pro}\n",
        OPEN + "events: [{type: trace, vehicle: 1, at_s: 1, points: [[0, 30.5], [9, 25]]}]",
        OPEN
        + "events:\n  - {vehicle: 1, at_s: 1, duration_s: 2, deceleration_mps2: 3}\n"
        + "  - {type: trace, vehicle: 1, at_s: 9, points: [[0, 24], [9, 25]]}\n",
        "fleet: {gap_m: 9, groups: [{name: a, vehicles: all, desired_gap_m: 9}]}",
    ],
)
def test_plausible_settings_have_no_note(write: Write, text: str) -> None:
    write(text)
    assert notes() == []


def test_a_note_has_the_place_that_causes_it(write: Write) -> None:
    write("duration_s: 60\ncontrol: {schedule: [{at_s: 30, model: FM}]}\n")
    assert notes(duration_s=20.0) == [
        "control.schedule.0.at_s: 30 is not before the end of the run (20 s)  (--duration-s 20.0)"
    ]


def test_notes_are_printed_and_logged_and_refused_if_strict(write: Write, tmp_path: Path) -> None:
    write("duration_s: 2\nfleet: {size: 3}\ncontrol: {schedule: [{at_s: 30, model: FM}]}\n")
    note = "control.schedule.0.at_s: 30 is not before the end of the run (2 s)  (s.yaml, line 3)"
    checked = zenvoy(tmp_path, "check", "s.yaml")
    assert (checked.code, checked.err) == (0, f"note: {note}\n")
    for command in (("check", "s.yaml"), ("run", "s.yaml", "--bus", "in-process", "--out", "r")):
        strict = zenvoy(tmp_path, *command, "--strict")
        assert (strict.code, strict.out, strict.err) == (2, "", f"{note}\n")
    assert not Path("r").exists()
    ran = zenvoy(tmp_path, "run", "s.yaml", "--bus", "in-process", "--out", "r")
    assert (ran.code, ran.err) == (0, f"note: {note}\n")
    run = load_log("r/run.mcap")
    kept = note.partition("  (")[0]  # a log has no paths of the machine that wrote it
    assert run.run["notes"] == kept
    assert run.notes == (f"the scenario: {kept}",)
    assert json.loads(Path("r/summary.json").read_text())["notes"] == list(run.notes)
    assert zenvoy(tmp_path, "analyze", "r/run.mcap").code == 0
    assert "is not before the end of the run" in Path("r/run-analysis/report.html").read_text()
