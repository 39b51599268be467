"""The chapter on estimation agrees with closed forms, filterpy, scipy, and the log itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from tests.logs import write_log
from zenvoy.analysis import load
from zenvoy.analysis.chapters.estimation import estimation_section
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.agreement import agreement
from zenvoy.analysis.measures.consistency import (
    consistency,
    interval,
    normalised_error,
    normalised_innovation,
    spread,
)
from zenvoy.analysis.measures.quantities import first_disturbed, quantities
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.section import Section, Sheet

PBCM = """
duration_s: 30
seed: 3
fleet: {size: 6}
control: {model: PBCM, v2v_wait_ms: 50, system_delay_ms: 100}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
sensors: {error: 0.1}
events:
  - {vehicle: 3, at_s: 5, duration_s: 2, deceleration_mps2: 3}
  - {vehicle: 4, at_s: 4, duration_s: 1, deceleration_mps2: 1}
"""


@pytest.fixture(scope="module")
def run(folder: Path) -> Run:
    return load(write_log(folder / "pbcm.mcap", PBCM))


@pytest.fixture(scope="module")
def section(run: Run) -> Section:
    return estimation_section(run)


def cell(sheet: Sheet, column: str, *row: str) -> Any:
    """Return a cell of the row that begins with these cells."""
    found = [cells for cells in sheet.rows if cells[: len(row)] == row]
    assert len(found) == 1
    return found[0][sheet.columns.index(column)]


# Agreement


def test_agreement_by_hand() -> None:
    found = agreement(np.array([2.0, 4.0, 6.0, np.nan]), np.array([1.0, 2.0, 3.0, 4.0]))
    assert found is not None
    assert found.rmse == pytest.approx(np.sqrt(14.0 / 3.0))  # errors 1, 2, 3
    assert found.r2 == pytest.approx(1.0 - 14.0 / 2.0)  # SS_tot of 1, 2, 3
    assert found.r2_correlation == pytest.approx(1.0)  # twice the truth
    assert found.samples == 3


def test_agreement_of_no_values_is_unknown() -> None:
    assert agreement(np.array([np.nan]), np.array([1.0])) is None


def test_agreement_if_the_values_or_the_truth_do_not_vary() -> None:
    found = agreement(np.array([3.0, 3.0]), np.array([1.0, 2.0]))
    assert found is not None
    assert np.isnan(found.r2_correlation)
    found = agreement(np.array([1.0, 2.0]), np.array([3.0, 3.0]))
    assert found is not None
    assert np.isnan(found.r2)
    assert np.isnan(found.r2_correlation)


@given(st.lists(st.tuples(st.integers(-99, 99), st.integers(-99, 99)), min_size=3, max_size=30))
def test_agreement_agrees_with_scipy(pairs: list[tuple[int, int]]) -> None:
    values, truth = np.array(pairs, float).T
    found = agreement(values, truth)
    assert found is not None
    if np.ptp(values) and np.ptp(truth):
        expected = stats.pearsonr(values, truth).statistic ** 2
        assert found.r2_correlation == pytest.approx(expected, abs=1e-9)
    # The best line through the points is at least as good as the values themselves.
    if np.ptp(truth) and np.ptp(values):
        assert found.r2 <= found.r2_correlation + 1e-9


# Consistency


def test_the_interval_is_that_of_the_chi_squared_distribution() -> None:
    low, high = interval(np.array([1, 2, 40, 1000]))
    for m, a, b in zip((1, 2, 40, 1000), low, high, strict=True):
        np.testing.assert_allclose((a, b), stats.chi2(m).ppf([0.025, 0.975]) / m)


def test_spread_by_hand() -> None:
    error = np.array([0.5, -1.5, 2.5, -3.5, np.nan, 1.0])
    assert spread(error, np.array([1.0] * 4 + [1.0, np.nan])) == (0.25, 0.5, 0.75)
    assert spread(np.array([np.nan]), np.array([1.0])) is None


def simulate(
    *, runs: int, steps: int, process: float, reading: float, claimed: float = 1.0
) -> tuple[KalmanFilter, list[NDArray[Any]]]:
    """Run constant-velocity filters of filterpy on simulated gaps.

    `claimed` is the Q of the filters as a multiple of the true Q. Return true states, readings,
    estimates (steps, runs, 2), covariances (steps, 2, 2), and innovations with their covariances.
    """
    rng = np.random.default_rng(7)
    f, b = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([0.005, 0.1])
    r = np.diag([reading**2, (0.5 * reading) ** 2])
    truth = rng.multivariate_normal([37.5, 0.0], r, size=runs)
    filters = []
    for _ in range(runs):
        kalman = KalmanFilter(dim_x=2, dim_z=2)
        kalman.F, kalman.H, kalman.R, kalman.P = f, np.eye(2), r, r.copy()
        kalman.Q = claimed * process**2 * np.outer(b, b)
        kalman.x = np.array([37.5, 0.0])
        filters.append(kalman)
    columns: list[list[Any]] = [[] for _ in range(6)]
    for _ in range(steps):
        truth = truth @ f.T + rng.normal(0.0, process, size=(runs, 1)) * b
        z = truth + rng.multivariate_normal([0.0, 0.0], r, size=runs)
        for kalman, reading_of in zip(filters, z, strict=True):
            kalman.predict()
            kalman.update(reading_of)
        row = (
            truth,
            z,
            np.array([kalman.x for kalman in filters]),
            filters[0].P,
            np.array([kalman.y for kalman in filters]),
            filters[0].S,
        )
        for column, value in zip(columns, row, strict=True):
            column.append(value)
    return filters[0], [np.array(column) for column in columns]


def test_the_innovation_follows_from_the_residual() -> None:
    """νᵀ S⁻¹ ν of the prediction equals (z - x̂)ᵀ (R - P)⁻¹ (z - x̂) of the logged values."""
    kalman, (_, z, x, p, y, s) = simulate(runs=3, steps=50, process=0.5, reading=2.0)
    left = np.einsum("tri,tij,trj->tr", y, np.linalg.inv(s), y)
    residual = z - x
    right = np.einsum("tri,tij,trj->tr", residual, np.linalg.inv(kalman.R - p), residual)
    np.testing.assert_allclose(left, right, rtol=1e-6)


@given(st.floats(0.1, 10), st.floats(0.05, 10), st.floats(-20, 20), st.floats(-20, 20))
def test_the_innovation_of_a_scalar_is_exact(p: float, r: float, x: float, z: float) -> None:
    after = p * r / (p + r)
    estimate = x + p / (p + r) * (z - x)
    args = [np.array([value]) for value in (z, estimate, np.sqrt(after), r)]
    found = normalised_innovation(*args)
    if after > r / 2 * (1 + 1e-9):
        assert np.isnan(found[0])
    elif after < r / 2 * (1 - 1e-9):
        assert found[0] == pytest.approx((z - x) ** 2 / (p + r), rel=1e-6, abs=1e-9)


def test_a_filter_with_the_right_covariance_is_consistent() -> None:
    kalman, (truth, z, x, p, _, _) = simulate(runs=30, steps=800, process=0.5, reading=2.0)
    for of in (0, 1):
        std = np.sqrt(p[:, of, of])[:, None] * np.ones((1, 30))
        variance = np.full_like(std, kalman.R[of, of])
        error = x[:, :, of] - truth[:, :, of]
        nis = consistency(normalised_innovation(z[:, :, of], x[:, :, of], std, variance))
        nees = consistency(normalised_error(error, std))
        within = spread(error, std)
        assert nis is not None
        assert nees is not None
        assert within is not None
        # 800 independent cycles have 95 ± 0.8 %. Errors are correlated and scatter more.
        assert nis.share_inside == pytest.approx(0.95, abs=0.025)
        assert nis.mean == pytest.approx(1.0, abs=0.05)
        assert nees.share_inside == pytest.approx(0.95, abs=0.06)
        assert nees.mean == pytest.approx(1.0, abs=0.15)
        np.testing.assert_allclose(within, (0.683, 0.954, 0.997), atol=0.04)


def test_an_overconfident_filter_is_detected() -> None:
    kalman, (truth, z, x, p, _, _) = simulate(
        runs=30, steps=300, process=2.0, reading=2.0, claimed=0.01
    )
    std = np.sqrt(p[:, 0, 0])[:, None] * np.ones((1, 30))
    nees = consistency(normalised_error(x[:, :, 0] - truth[:, :, 0], std)[100:])
    assert nees is not None
    assert nees.mean > 2.0
    assert nees.share_inside < 0.1
    variance = np.full_like(std, kalman.R[0, 0])
    nis = consistency(normalised_innovation(z[:, :, 0], x[:, :, 0], std, variance))
    assert nis is not None
    assert nis.mean > 1.1


def test_consistency_leaves_out_unknown_values() -> None:
    nan = np.nan
    found = consistency(np.array([[1.0, nan, 3.0], [nan, nan, nan], [0.0, 0.0, 0.0]]))
    assert found is not None
    np.testing.assert_array_equal(found.per_cycle, [2.0, nan, 0.0])
    low, high = interval(np.array([2, 3]))
    np.testing.assert_array_equal(found.low, [low[0], nan, low[1]])
    np.testing.assert_array_equal(found.high, [high[0], nan, high[1]])
    assert found.mean == pytest.approx(4.0 / 5.0)
    assert found.share_inside == 0.5
    assert consistency(np.full((2, 2), nan)) is None


# From a log


def test_quantities_are_at_their_own_time(run: Run) -> None:
    found = {quantity.name: quantity for quantity in quantities(run)}
    assert list(found) == [
        "own speed",
        "gap ahead",
        "relative speed ahead",
        "gap behind",
        "relative speed behind",
    ]
    position, speed = run.truth["position"], run.truth["speed"]
    ring_m = 6 * 37.5
    estimate, behind = run.estimate, found["gap behind"]
    late = 0
    seen: set[tuple[int, int]] = set()
    for cycle in range(run.cycles):
        for vehicle in range(6):
            ahead = position[cycle, vehicle - 1] + (ring_m if vehicle == 0 else 0.0)
            gap = ahead - position[cycle, vehicle]
            follower = (vehicle - 1) % 6
            assert found["gap ahead"].true[cycle, vehicle] == gap
            change = speed[cycle, follower] - speed[cycle, vehicle]
            assert found["relative speed ahead"].true[cycle, vehicle] == change
            assert behind.true[cycle, follower] == gap
            assert behind.measured[cycle, follower] == run.radar["gap"][cycle, vehicle]
            of = estimate["behind_measured_ns"][cycle, vehicle] // run.scenario.period_ns
            late += of < cycle
            if of >= 0:
                seen.add((of, vehicle))
                assert behind.estimated[of, vehicle] == estimate["behind_gap"][cycle, vehicle]
                assert behind.std[of, vehicle] == estimate["behind_gap_std"][cycle, vehicle]
    assert late > 100  # frames come late, or not at all
    assert int((~np.isnan(behind.estimated)).sum()) == len(seen) < run.cycles * 6
    np.testing.assert_array_equal(found["gap ahead"].estimated, estimate["ahead_gap"])


def test_readings_have_the_stated_variance(run: Run) -> None:
    for quantity in quantities(run):
        share = (quantity.measured - quantity.true) / np.sqrt(quantity.reading_variance)
        assert float(share.std()) == pytest.approx(1.0, abs=0.05)
        assert np.abs(share).max() <= np.sqrt(3.0) + 1e-9  # uniform


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


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 6))
def test_each_vehicle_can_be_judged_separately(run: Run, vehicle: int) -> None:
    speed = quantities(run)[0]
    one = agreement(speed.estimated[:, vehicle - 1], speed.true[:, vehicle - 1])
    assert one is not None
    assert one.samples == run.cycles
    assert one.rmse < 1.0
