"""Reports compare gaps and speeds with a schedule that changes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.manoeuvres import changes, manoeuvres_section
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.theory.of_run import theory_of
from zenvoy.scenarios import Gains

SCENARIO = """
duration_s: 70
road: {type: open}
fleet: {size: 4, gap_m: 20}
sensors: {error: 0}
control:
  model: CACC
  desired_gap_m: 20
  platoon: {omega_n: 0.5}
  schedule:
    - {at_s: 5, vehicles: 3, desired_gap_m: 30, ramp_s: 10}
    - {at_s: 30, vehicles: 1, desired_speed_mps: 28, ramp_s: 4}
    - {at_s: 50, vehicles: 3, desired_gap_m: 25}
    - {at_s: 68, vehicles: 3, desired_gap_m: 15, ramp_s: 30}
    - {at_s: 90, vehicles: 3, desired_gap_m: 20}
"""


def test_true_values_are_shown_beside_the_desired_ones(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "run.mcap", SCENARIO))
    section = manoeuvres_section(run)
    assert section is not None
    (sheet,) = section.sheets
    cells = [dict(zip(sheet.columns, row, strict=True)) for row in sheet.rows]
    asked = [tuple(row[name] for name in ("from, s", "to, s", "vehicle", "what")) for row in cells]
    assert asked == [
        (5.0, 15.0, 3, "desired gap, m"),
        (30.0, 34.0, 1, "desired speed, m/s"),
        (50.0, 50.0, 3, "desired gap, m"),
        (68.0, 90.0, 3, "desired gap, m"),  # cut short by the next entry, after the run
    ]
    assert [(row["before"], row["after"]) for row in cells[:3]] == [(20, 30), (30, 28), (30, 25)]
    assert cells[3]["after"] == pytest.approx(25 - 10 * 22 / 30)
    assert cells[0]["actual before the next"] == pytest.approx(30.0, abs=0.1)
    assert cells[1]["actual at the end of the change"] == pytest.approx(28.0, abs=0.3)
    assert cells[2]["actual at the end of the change"] == pytest.approx(30.0, abs=0.1)  # at once
    assert 15.0 < float(str(cells[0]["reached at, s"])) < 30.0
    assert 30.0 < float(str(cells[1]["reached at, s"])) < 34.2
    assert (cells[3]["actual at the end of the change"], cells[3]["reached at, s"]) == (None, None)
    (picture,) = section.pictures
    assert drawn(picture).png
    found = [(h.start_s, h.text) for h in happenings(run) if h.kind == "manoeuvre"]
    assert found[0] == (5.0, "new targets of vehicle 3: desired gap 30 m")
    assert [chapter.title for chapter in chapters(run)][:2] == ["Motion", "Manoeuvres"]


def test_without_a_change_of_targets_there_is_no_chapter(tmp_path: Path) -> None:
    text = "duration_s: 3\ncontrol: {schedule: [{at_s: 1, model: FM}, {at_s: 9, desired_gap_m: 9}]}"
    run = load(write_log(tmp_path / "run.mcap", text))
    assert changes(run) == []
    assert manoeuvres_section(run) is None
    assert "Manoeuvres" not in [chapter.title for chapter in chapters(run)]


def test_theory_takes_the_gains_in_force(tmp_path: Path) -> None:
    text = """
        duration_s: 6
        fleet: {size: 4}
        control:
          model: FM
          schedule:
            - {at_s: 2, gains: {k_v: 0.9}}
            - {at_s: 4, gains: {k_d: 0.3}, ramp_s: 1}
    """
    run = load(write_log(tmp_path / "run.mcap", text))
    for low_s, high_s, gains in (
        (0.0, 1.9, Gains()),
        (2.0, 4.0, Gains(k_v=0.9)),
        (5.1, 6.0, Gains(k_v=0.9, k_d=0.3)),
    ):
        theory = theory_of(run, low_s, high_s)
        assert {member.gains for member in theory.members} == {gains}
        assert not any("changes gains" in caveat for caveat in theory.caveats)
    theory = theory_of(run, 1.0, 3.0)
    assert {member.gains for member in theory.members} == {Gains()}
    assert any("changes gains" in caveat for caveat in theory.caveats)
