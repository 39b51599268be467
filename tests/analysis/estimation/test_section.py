"""The chapter on estimation agrees with the log, and notes what it cannot judge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.analysis.estimation.conftest import PBCM
from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.estimation import estimation_section
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.quantities import first_disturbed
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.section import Section, Sheet


@pytest.fixture(scope="module")
def section(run: Run) -> Section:
    return estimation_section(run)


def cell(sheet: Sheet, column: str, *row: str) -> Any:
    """Return a cell of the row that begins with these cells."""
    found = [cells for cells in sheet.rows if cells[: len(row)] == row]
    assert len(found) == 1
    return found[0][sheet.columns.index(column)]


def test_the_sheets_agree_with_the_log(run: Run, section: Section) -> None:
    fleet, vehicle, consistent = section.sheets
    speed, gap = (
        run.truth["speed"][:-1],
        run.truth["position"][:-1, 2] - run.truth["position"][:-1, 3],
    )
    assert vehicle.title == "Agreement with the truth, vehicle 4"  # which brakes first
    for kind, values in (("measured", run.radar["speed"]), ("estimated", run.estimate["speed"])):
        row = ("own speed, m/s", kind)
        error = values - speed
        assert cell(fleet, "RMSE", *row) == pytest.approx(np.sqrt((error**2).mean()))
        r2 = 1.0 - (error**2).mean() / speed.var()
        assert cell(fleet, "R²", *row) == (pytest.approx(r2) if r2 >= 0.0 else None)
        assert cell(fleet, "spread of the truth", *row) == pytest.approx(speed.std())
        correlation = np.corrcoef(values.ravel(), speed.ravel())[0, 1]
        assert cell(fleet, "R² (correlation)", *row) == pytest.approx(correlation**2)
        assert cell(fleet, "samples", *row) == 300 * 6
    for kind, values in (("measured", run.radar["gap"]), ("estimated", run.estimate["ahead_gap"])):
        found = cell(vehicle, "RMSE", "gap ahead, m", kind)
        assert found == pytest.approx(np.sqrt(((values[:, 3] - gap) ** 2).mean()))
    for judged in consistent.rows:
        name, within_1, _, within_3, nees, _, nis, inside = judged
        assert isinstance(within_1, float)
        assert isinstance(within_3, float)
        assert 60.0 < within_1 < within_3 <= 100.0, name
        assert isinstance(nees, float)
        assert isinstance(nis, float)
        assert 0.1 < nees < 1.5
        assert nis == pytest.approx(1.0, abs=0.15)
        assert isinstance(inside, float)
        assert inside > 95.0  # uniform errors scatter less than χ²


def test_estimates_are_closer_to_the_truth_than_readings(section: Section) -> None:
    for sheet in section.sheets[:2]:
        for quantity in {str(row[0]) for row in sheet.rows}:
            measured = cell(sheet, "RMSE", quantity, "measured")
            assert cell(sheet, "RMSE", quantity, "estimated") < 0.5 * measured


def test_pictures_can_be_drawn(section: Section) -> None:
    names = [picture.name for picture in section.pictures]
    assert names == ["estimation-truth", "estimation-error", "estimation-consistency"]
    for picture in section.pictures:
        files = drawn(picture)
        assert files.png.startswith(b"\x89PNG")
        assert b"</svg>" in files.svg
        assert len(files.svg) < 1_000_000
        assert picture.caption.endswith(".")


def test_every_row_has_a_cell_for_each_column(section: Section) -> None:
    for sheet in section.sheets:
        assert {len(row) for row in sheet.rows} == {len(sheet.columns)}


def test_a_run_without_estimates_has_a_note(folder: Path) -> None:
    run = load(write_log(folder / "bcm.mcap", PBCM.replace("model: PBCM", "model: BCM")))
    section = estimation_section(run)
    assert (section.sheets, section.pictures) == ((), ())
    assert section.notes == ("No filter ran: the models of this run act on readings directly.",)


def test_a_run_without_a_cycle_has_a_note(folder: Path) -> None:
    section = estimation_section(load(write_log(folder / "none.mcap", PBCM, until_cycle=0)))
    assert section.notes == ("No cycle was logged, so there is nothing to compare.",)


def test_the_chapter_shows_the_first_disturbed_vehicle(folder: Path, run: Run) -> None:
    assert first_disturbed(run) == 4
    calm = "{duration_s: 1, fleet: {size: 7}}"
    assert first_disturbed(load(write_log(folder / "calm.mcap", calm))) == 4
    lead = """
duration_s: 3
fleet: {size: 3}
road: {type: open}
events: [{vehicle: 1, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""
    lead_brakes = load(write_log(folder / "lead.mcap", lead))
    assert first_disturbed(lead_brakes) == 2
    section = estimation_section(lead_brakes)
    assert cell(section.sheets[0], "samples", "gap ahead, m", "measured") == 2 * 30
    for picture in section.pictures:
        drawn(picture)


def test_a_vehicle_without_estimates_is_not_shown(folder: Path) -> None:
    """This holds even for the vehicle that brakes, such as a human driver among others."""
    text = """
duration_s: 6
fleet: {size: 5, groups: [{name: humans, vehicles: "2, 3", model: FM, beacons: false}]}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""
    run = load(write_log(folder / "humans.mcap", text))
    section = estimation_section(run)
    assert first_disturbed(run) == 2
    assert section.sheets[1].title == "Agreement with the truth, vehicle 4"
    assert cell(section.sheets[1], "samples", "gap ahead, m", "estimated") > 0
    assert any("2 of 5 vehicles run no filter" in note for note in section.notes)
    for picture in section.pictures:
        drawn(picture)


def test_an_interrupted_run_is_judged_up_to_its_end(folder: Path) -> None:
    section = estimation_section(load(write_log(folder / "i.mcap", PBCM, until_cycle=50)))
    assert 40 * 6 < cell(section.sheets[0], "samples", "own speed, m/s", "measured") <= 50 * 6
    for picture in section.pictures:
        drawn(picture)


def test_links_by_position_have_no_innovation(folder: Path) -> None:
    text = PBCM.replace("model: PBCM,", "model: PBCM, neighbour_state: position,")
    section = estimation_section(load(write_log(folder / "p.mcap", text)))
    sheet = section.sheets[2]
    assert cell(sheet, "mean NIS", "gap ahead, m") is None
    assert cell(sheet, "mean NIS", "own speed, m/s") == pytest.approx(1.0, abs=0.15)
    assert any("differences of reported positions" in note for note in section.notes)
    for picture in section.pictures:
        drawn(picture)


def test_sensors_without_error_are_noted(folder: Path) -> None:
    text = PBCM.replace("error: 0.1", "error: 0").replace("duration_s: 30", "duration_s: 6")
    section = estimation_section(load(write_log(folder / "exact.mcap", text)))
    assert cell(section.sheets[2], "mean NIS", "own speed, m/s") is None
    assert any("have no error" in note for note in section.notes)
    for picture in section.pictures:
        drawn(picture)
