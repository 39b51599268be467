"""The chapter "String stability" notes what it leaves out, and where theory does not apply."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.analysis.stability_chapter import BRAKE, QUIET, chapter, sheet


@pytest.mark.parametrize(
    ("control", "why"),
    [
        ("model: CACC", "ran CACC, which has no linear form"),
        ("model: BCM, neighbour_state: position", "not by reported positions"),
        ("model: BCM, gains: {k_d: 0, k_v: 0.5, k_c: 0.1}", "k_d is 0"),
    ],
)
def test_a_note_gives_the_reason_for_missing_theory(tmp_path: Path, control: str, why: str) -> None:
    scenario = f"duration_s: 20\nfleet: {{size: 6}}\ncontrol: {{{control}}}\n"
    section = chapter(tmp_path, QUIET + scenario + BRAKE)
    assert any(why in note for note in section.notes)
    rows = sheet(section, "stability-vehicles").rows
    assert all(row[3] is None and row[2] is not None for row in rows)


def test_notes_name_what_a_run_has_beyond_theory(tmp_path: Path) -> None:
    section = chapter(
        tmp_path,
        "duration_s: 15\nfleet: {size: 6}\ncontrol: {model: PBCM, beacon_age_limit_ms: 150}\n"
        "channel: {loss: {p: 0.3}}\n" + BRAKE,
    )
    notes = "\n".join(section.notes)
    assert "scatter by" in notes
    assert "ignores the dynamics of the filter" in notes
    assert "under a law other than their most frequent one" in notes
    late = chapter(
        tmp_path,
        QUIET + "duration_s: 15\nfleet: {size: 6}\ncontrol: {model: BCM, v2v_wait_ms: 0}\n" + BRAKE,
    )
    assert any("100 ms old on average" in note for note in late.notes)


def test_an_unstable_fleet_has_a_note(tmp_path: Path) -> None:
    control = "control: {model: BCM, gains: {k_d: 0.1, k_v: 3, k_c: 0.05}}\n"
    section = chapter(tmp_path, QUIET + "duration_s: 10\nfleet: {size: 6}\n" + control + BRAKE)
    assert any("the fleet is unstable" in note for note in section.notes)


def test_a_string_beyond_150_vehicles_has_no_theory_by_vehicle(tmp_path: Path) -> None:
    scenario = "duration_s: 7\nfleet: {size: 151}\ncontrol: {model: FM}\n"
    section = chapter(tmp_path, QUIET + scenario + BRAKE)
    assert "Theory by vehicle is left out for more than 150 vehicles." in section.notes
    assert len(sheet(section, "stability-vehicles").rows) == 151
