"""The chapter "Motion" is right for small runs, and can be drawn."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.logs import write_log
from zenvoy.analysis import load, summarize
from zenvoy.analysis.chapters.motion import motion_section
from zenvoy.analysis.chapters.motion_pictures import pieces_of
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.instants import instants
from zenvoy.analysis.page.section import Section

RING = """
duration_s: 31
fleet: {size: 5}
sensors: {error: 0.03}
control: {model: FM, schedule: [{at_s: 1, model: PBCM}]}
events:
  - {vehicle: 2, at_s: 12, duration_s: 1, deceleration_mps2: 3}
"""
OPEN_PAIR = """
duration_s: 2
fleet: {size: 2}
road: {type: open}
control: {model: FM}
"""
CRASH = """
duration_s: 4
fleet: {size: 3, gap_m: 6}
control: {model: FM, desired_gap_m: 6}
events:
  - {vehicle: 1, at_s: 0.5, duration_s: 3, deceleration_mps2: 9}
"""


def made(folder: Path, scenario: str, until_cycle: int | None = None) -> Run:
    return load(write_log(folder / "run.mcap", scenario, until_cycle=until_cycle))


@pytest.fixture(scope="module")
def ring(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return made(tmp_path_factory.mktemp("motion"), RING)


def figures(section: Section) -> dict[object, Any]:
    sheet = next(sheet for sheet in section.sheets if sheet.name == "motion-figures")
    return {row[0]: row[2] for row in sheet.rows}


def check(section: Section) -> None:
    """Check that every row fits its columns, and that every picture can be drawn."""
    assert section.title == "Motion"
    for sheet in section.sheets:
        assert sheet.rows
        assert {len(row) for row in sheet.rows} == {len(sheet.columns)}
    names = [sheet.name for sheet in section.sheets]
    names += [picture.name for picture in section.pictures]
    assert len(set(names)) == len(names)
    for picture in section.pictures:
        file = BytesIO()
        picture.draw().savefig(file, format="png", dpi=50)
        assert file.tell() > 2_000


def test_distances_equal_those_of_the_summary(ring: Run) -> None:
    section = motion_section(ring)
    check(section)
    summary = summarize(ring.log)
    rows = {row[0]: row for row in section.sheets[0].rows}
    assert rows.keys() == {"before braking", "dip", "end"}
    for name, distance in summary["distance_m"].items():
        _, low, mean, high = rows[name.replace("_", " ")]
        assert (low, high) == (distance["min"], distance["max"])
        assert mean == pytest.approx(37.5)  # the ring's length over the number of vehicles
    assert figures(section)["smallest gap"] == summary["smallest_gap_m"]


def test_the_ring_has_its_figures(ring: Run) -> None:
    found = figures(motion_section(ring))
    assert found["collisions"] == 0
    assert found["flow, density × mean speed"] == pytest.approx(
        ring.truth["speed"].mean() / 37.5 * 3600.0
    )
    assert found["flow, counted at a point"] == pytest.approx(2_880.0, abs=150.0)
    assert found["mean time headway"] == pytest.approx(1.25, abs=0.05)
    assert found["time at the acceleration limits"] >= 100.0 / 31.0 / 5.0
    assert 7.0 < found["fuel"] < 9.0


def test_snapshots_equal_the_run(ring: Run) -> None:
    section = motion_section(ring)
    assert [row[0] for row in section.sheets[1].rows] == [12.0, 13.0, 14.0, 17.0, 22.0]
    assert section.sheets[1].title == "Speeds at instants from the first disturbance on"
    assert section.notes == ()
    assert summarize(ring.log)["speed_spread_at_100_s_mps"] is None


def test_the_papers_snapshot_times_are_for_its_cases_only(ring: Run) -> None:
    paper = replace(ring, name="paper/case-15")
    section = motion_section(paper)
    assert [row[0] for row in section.sheets[1].rows] == [9.0, 30.0]
    assert section.sheets[1].title == "Speeds at the instants that the paper uses"
    assert section.notes == ("The run ends before 100 and 300 s, so snapshots are missing.",)
    assert instants(paper) == [(9.0, 90), (30.0, 300)]


def test_two_vehicles_on_the_open_road_have_their_figures(tmp_path: Path) -> None:
    section = motion_section(made(tmp_path, OPEN_PAIR))
    check(section)
    assert [sheet.name for sheet in section.sheets] == [
        "motion-distances",
        "motion-speeds",
        "motion-figures",
    ]
    assert section.notes[0].startswith("No vehicle was disturbed")
    found = figures(section)
    assert found["smallest gap"] == pytest.approx(37.5, abs=1.0)
    assert found["flow, counted at a point"] is None  # only the vehicle behind passes


def test_a_crash_has_its_figures(tmp_path: Path) -> None:
    section = motion_section(made(tmp_path, CRASH))
    check(section)
    found = figures(section)
    assert found["collisions"] != 0
    assert found["smallest gap"] == pytest.approx(5.0)
    assert found["smallest time to collision"] < 1.5
    assert found["time to collision below 1.5 s, integrated (TIT)"] > 0.0


def test_runs_of_few_cycles_have_a_chapter(tmp_path: Path) -> None:
    run = made(tmp_path, OPEN_PAIR, until_cycle=2)
    assert len(run.time_s) == 3
    check(motion_section(run))
    nothing = made(tmp_path, OPEN_PAIR, until_cycle=0)
    assert len(nothing.time_s) < 2
    section = motion_section(nothing)
    assert section.notes == ("No cycle was logged, so there is no motion to show.",)
    assert not section.pictures


def test_pieces_of_a_line_break_at_the_seam() -> None:
    position = np.array([[80.0, 10.0], [110.0, 40.0]])
    pieces, speed = pieces_of(np.array([0.0, 1.0]), position, np.array([[20.0, 30.0]] * 2), 100.0)
    expected = [[[0, 80], [1, 110]], [[0, 10], [1, 40]], [[0, -20], [1, 10]]]
    np.testing.assert_allclose(pieces, expected)
    assert speed.tolist() == [20.0, 30.0, 20.0]
    assert len(pieces_of(np.array([0.0, 1.0]), position, position, None)[0]) == 2


@given(st.integers(2, 30), st.integers(1, 5), st.floats(50.0, 500.0), st.floats(0.1, 45.0))
def test_no_piece_goes_round_the_ring(rows: int, n: int, ring_m: float, speed: float) -> None:
    time = np.arange(float(rows))
    position = np.arange(n) * ring_m / n + speed * time[:, None]
    pieces, values = pieces_of(time, position, np.full_like(position, speed), ring_m)
    way = pieces[:, 1, 1] - pieces[:, 0, 1]
    np.testing.assert_allclose(way, speed, rtol=1e-6)
    assert (pieces[:, 0, 1] <= ring_m + 1e-6).all()
    assert (pieces[:, 1, 1] >= -1e-6).all()
    assert len(pieces) == len(values)
