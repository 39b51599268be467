"""The chapter "String stability" is right for small runs, and notes what it cannot measure."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.analysis.stability_chapter import BRAKE, QUIET, chapter, pictures, sheet
from tests.logs import write_log
from zenvoy.analysis import load


def test_gains_of_fm_behind_a_braking_agree_with_theory(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 60\nroad: {type: open}\nfleet: {size: 6}\ncontrol: {model: FM}\n"
        "events: [{type: brake, vehicle: 1, at_s: 2, duration_s: 1, deceleration_mps2: 1}]\n",
    )
    figures = {row[0]: row[2:] for row in sheet(section, "stability-figures").rows}
    assert figures["string-stable without delay and lag: κ² + 2 k_v κ ≥ 2 k_d"] == (None, "no")
    for name in (
        "peak gain to the next vehicle",
        "largest L2 gain from one vehicle to the next",
        "largest L∞ gain from one vehicle to the next",
        "L∞ gain to the vehicle 5 places behind",
        "dip backwards, speed from vehicle to vehicle",
    ):
        measured, theory = figures[name]
        assert measured == pytest.approx(theory, rel=0.01), name
    vehicles = sheet(section, "stability-vehicles").rows
    assert [row[:2] for row in vehicles] == [(1 + k, k) for k in range(6)]
    assert vehicles[0][2:5] == (1.0, 1.0, None)
    gains = [float(row[5] or 0.0) for row in vehicles]
    assert gains == sorted(gains)  # it is not string-stable
    steps = [float(row[7] or 0.0) for row in vehicles[1:]]
    assert math.prod(steps) == pytest.approx(gains[-1])
    assert section.notes == ("An open road has no modes, so only gains and waves are shown.",)
    expected = {"stability-gains", "stability-frequency", "stability-wave"}
    assert pictures(section) == expected


def test_a_wave_under_bcm_goes_both_ways_round_the_ring(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 60\nfleet: {size: 9}\ncontrol: {model: BCM}\n" + BRAKE,
    )
    rows = sheet(section, "stability-vehicles").rows
    assert [row[1] for row in rows] == [-4, -3, -2, -1, 0, 1, 2, 3, 4]
    assert [row[0] for row in rows] == [7, 8, 9, 1, 2, 3, 4, 5, 6]
    for before, after in zip(rows[:4], reversed(rows[5:]), strict=True):
        assert before[2:] == pytest.approx(after[2:], rel=1e-6)  # the same both ways
    assert pictures(section) >= {"stability-modes", "stability-gains"}
    modes = sheet(section, "stability-modes").rows
    assert [row[0] for row in modes] == [1, 2, 3, 4]
    assert modes[0][1] == pytest.approx(modes[0][2], rel=0.05)


def test_a_chirp_has_no_dip_to_follow(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 60\nfleet: {size: 5}\ncontrol: {model: BCM}\n"
        "events: [{type: sine, vehicle: 1, at_s: 2, duration_s: 20, amplitude_mps: 1,"
        " frequency_hz: 0.05}]\n",
    )
    assert "stability-wave" not in pictures(section)
    assert not any("dip" in str(row[0]) for row in sheet(section, "stability-figures").rows)


def test_without_a_disturbance_nothing_is_measured(tmp_path: Path) -> None:
    section = chapter(tmp_path, "duration_s: 5\nfleet: {size: 4}\n")
    assert not section.sheets
    assert section.notes == (
        "No vehicle was disturbed, so there are no gains, waves or modes to measure.",
    )


def test_in_a_short_record_nothing_is_measured(tmp_path: Path) -> None:
    section = chapter(tmp_path, "duration_s: 3\nfleet: {size: 4}\n" + BRAKE)
    assert section.notes == ("Too little time is left after the disturbance to analyse it.",)


def test_times_after_a_crash_are_left_out(tmp_path: Path) -> None:
    scenario = "duration_s: 20\nfleet: {size: 5}\ncontrol: {model: FM}\n"
    hard = "vehicle: 2, at_s: 1, duration_s: 3, deceleration_mps2: 9}]\n"
    section = chapter(tmp_path, f"{QUIET}{scenario}events: [{{type: brake, {hard}")
    assert any("left out because of a collision of vehicle 3" in note for note in section.notes)
    assert sheet(section, "stability-vehicles").rows


STOP_AND_GO = """
duration_s: 110
road: {type: open}
fleet: {size: 5, gap_m: 12, speed_mps: 0}
control: {model: FM, desired_gap_m: 25, desired_speed_mps: 12}
events: [{type: trace, vehicle: 1, at_s: 0.1, points: [[0, 0], [5, 0], [13, 12], [35, 12], [42, 0],
  [50, 0], [60, 15], [80, 15], [85, 5], [92, 12], [110, 12]]}]
"""


def test_stop_and_go_is_measured_by_its_linear_stretches(tmp_path: Path) -> None:
    path = write_log(tmp_path / "run.mcap", QUIET + STOP_AND_GO)
    section = chapter(tmp_path, QUIET + STOP_AND_GO)
    speed = load(path).truth["speed"]
    stretches = sheet(section, "stability-stretches").rows
    assert len(stretches) == 2
    for start_s, end_s, size, l2, linf, step in stretches:
        rows = speed[round(float(start_s or 0) * 10) : round(float(end_s or 0) * 10) + 1]
        assert len(rows) >= 100
        assert rows.min() >= 0.1
        assert size == pytest.approx(rows[:, 0].std())
        assert l2 == pytest.approx(rows[:, 4].std() / rows[:, 0].std())
        assert isinstance(linf, float)
        assert isinstance(step, float)
    longest = max(stretches, key=lambda row: float(row[1] or 0) - float(row[0] or 0))
    vehicles = sheet(section, "stability-vehicles").rows
    assert [row[0] for row in vehicles] == [1, 2, 3, 4, 5]
    assert vehicles[-1][2] == pytest.approx(longest[3])
    assert section.notes[0].startswith("At times some vehicle stands")
    assert f"This chapter covers {longest[0]:g} s to {longest[1]:g} s." in section.notes[1]
    assert pictures(section) == {"stability-gains"}


def test_a_braking_to_a_standstill_is_measured_by_what_follows(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 90\nfleet: {size: 6, speed_mps: 10, gap_m: 60}\n"
        "control: {model: BCM, desired_speed_mps: 10}\n"
        "events: [{type: brake, vehicle: 2, at_s: 2, duration_s: 9, deceleration_mps2: 1.2}]\n",
    )
    assert "This chapter covers 11" in section.notes[1]
    assert sheet(section, "stability-vehicles").rows
    assert "stability-modes" in pictures(section)
    assert "stability-wave" not in pictures(section)


def test_a_fleet_that_hardly_moves_has_a_note(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 20\nfleet: {size: 4, speed_mps: 0}\n"
        "control: {model: FM, desired_speed_mps: 0}\n"
        "events: [{type: brake, vehicle: 2, at_s: 2, duration_s: 3, deceleration_mps2: 2}]\n",
    )
    assert not section.sheets
    assert "No linear stretch lasts for 10 s or more." in section.notes[0]


def test_a_note_names_what_leaves_too_short_a_record(tmp_path: Path) -> None:
    scenario = "duration_s: 20\nfleet: {size: 5, gap_m: 6}\ncontrol: {model: FM}\n"
    hard = "vehicle: 2, at_s: 1, duration_s: 3, deceleration_mps2: 9}]\n"
    section = chapter(tmp_path, f"{QUIET}{scenario}events: [{{type: brake, {hard}")
    assert not section.sheets
    assert "a collision of vehicle 3" in section.notes[0]


def test_times_after_a_switch_or_another_disturbance_are_left_out(tmp_path: Path) -> None:
    events = BRAKE.replace(
        "]", ", {type: brake, vehicle: 4, at_s: 12, duration_s: 1, deceleration_mps2: 1}]"
    )
    control = "control: {model: BCM, schedule: [{at_s: 15, model: FM}]}\n"
    both = chapter(tmp_path, QUIET + "duration_s: 20\nfleet: {size: 5}\n" + control + events)
    assert any(
        "after 12 s is left out because of the disturbance of vehicle 4" in n for n in both.notes
    )
    switch = chapter(tmp_path, QUIET + "duration_s: 20\nfleet: {size: 5}\n" + control + BRAKE)
    assert any(
        "after 15 s is left out because of the switch to FM" in note for note in switch.notes
    )


def test_laws_mixed_on_the_ring_have_no_modes_in_closed_form(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        QUIET + "duration_s: 30\ncontrol: {model: BCM}\n"
        "fleet: {size: 6, groups: [{name: old, vehicles: 4, model: FM}]}\n" + BRAKE,
    )
    assert any("no theory of the modes" in note for note in section.notes)
    modes = sheet(section, "stability-modes").rows
    assert all(row[2] is None for row in modes)
    assert any(row[1] is not None for row in modes)
    assert all(row[3] is not None for row in sheet(section, "stability-vehicles").rows)
