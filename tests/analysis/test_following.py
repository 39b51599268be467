"""Measures of following match closed forms, and those of a run match its motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from tests.logs import write_log
from zenvoy.analysis import load, summarize
from zenvoy.analysis.chapters.motion import motion_section
from zenvoy.analysis.measures.following import ends, gap_error, swing_ratio
from zenvoy.links.distance import gaps

ROAD = """
duration_s: 25
road: {type: open}
fleet: {size: 4}
sensors: {error: 0}
control: {model: FM}
events:
  - {type: sine, vehicle: 1, at_s: 5, duration_s: 20, mean_mps: 30, amplitude_mps: 1,
     frequency_hz: 0.1}
"""
RING = """
duration_s: 8
fleet: {size: 5}
control: {model: BCM}
events: [{vehicle: 3, at_s: 2, duration_s: 1, deceleration_mps2: 3}]
"""
STEADY = """
duration_s: 2
fleet: {size: 4}
control: {model: FM}
"""


@given(
    st.tuples(st.integers(1, 12), st.integers(2, 9)).flatmap(
        lambda shape: hnp.arrays(np.float64, shape, elements=st.floats(1.0, 200.0))
    )
)
def test_on_a_ring_the_error_of_the_gaps_is_their_standard_deviation(
    gap: NDArray[np.float64],
) -> None:
    gap = gap * (100.0 / gap.sum(axis=1, keepdims=True))  # every row fills the ring
    assert gap_error(gap) == pytest.approx(gap.std(), abs=1e-9)


def test_a_fleet_that_breathes_evenly_has_no_error_of_its_gaps() -> None:
    gap = np.array([[np.nan, 10.0, 10.0], [np.nan, 30.0, 30.0]])
    assert gap_error(gap) == 0.0
    gap[0, 1], gap[0, 2] = 8.0, 12.0
    assert gap_error(gap) == pytest.approx(np.sqrt((4.0 + 4.0) / 4.0))


@given(st.floats(0.01, 100.0), st.floats(-3.0, 3.0))
def test_the_swing_ratio_is_the_gain_of_a_sine(gain: float, shift: float) -> None:
    angle = np.linspace(0.0, 20.0 * np.pi, 2000, endpoint=False)
    ratio = swing_ratio(30.0 + np.sin(angle), 20.0 + gain * np.sin(angle - shift))
    assert ratio == pytest.approx(gain)


def test_a_steady_head_has_no_swing() -> None:
    assert swing_ratio(np.full(9, 30.0), np.arange(9.0)) is None


def test_a_summary_has_the_figures_of_the_truth(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "run.mcap", ROAD))
    assert ends(run) == (0, 3, 5.0)
    summary = summarize(run.log)
    speed = run.truth["speed"][50:]
    assert summary["speed_swing_ratio"] == pytest.approx(speed[:, 3].std() / speed[:, 0].std())
    assert summary["tail_speed_swing_mps"] == pytest.approx(speed[:, 3].std())
    gap = gaps(run.truth["position"], None)[:, 1:]
    mean = gap.mean(axis=1)[:, None]
    assert summary["gap_error_rms_m"] == pytest.approx(np.sqrt(((gap - mean) ** 2).mean()))
    sheet = next(one for one in motion_section(run).sheets if one.name == "motion-figures")
    of_report = {row[0]: row[2] for row in sheet.rows}
    assert summary["acceleration_rms_mps2"] == of_report["acceleration, RMS"]
    assert summary["jerk_rms_mps3"] == of_report["jerk, RMS"]
    assert 0.1 < summary["acceleration_rms_mps2"] < 1.0


def test_on_a_ring_the_tail_is_the_vehicle_ahead_of_the_head(tmp_path: Path) -> None:
    run = load(write_log(tmp_path / "run.mcap", RING))
    assert ends(run) == (2, 1, 2.0)
    speed = run.truth["speed"][20:]
    ratio = summarize(run.log)["speed_swing_ratio"]
    assert ratio == pytest.approx(speed[:, 1].std() / speed[:, 2].std())


def test_a_ring_that_nothing_disturbs_has_no_head(tmp_path: Path) -> None:
    log = write_log(tmp_path / "run.mcap", STEADY)
    assert ends(load(log)) is None
    summary = summarize(log)
    assert summary["speed_swing_ratio"] is summary["tail_speed_swing_mps"] is None


def test_nothing_follows_the_last_vehicle_of_the_open_road(tmp_path: Path) -> None:
    last = ROAD.replace("vehicle: 1", "vehicle: 4")
    assert ends(load(write_log(tmp_path / "run.mcap", last))) is None
