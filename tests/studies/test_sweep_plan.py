"""A user's own studies have axes, plans and folders."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.studies.conftest import write_study
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.sweeps.axes import Axis, Choice, Listed, Lognormal, Normal, Range, Uniform
from zenvoy.studies.sweeps.plan import plan_of, points_of, size_of
from zenvoy.studies.sweeps.store import open_store
from zenvoy.studies.sweeps.study_file import read_study

GOOD = """
scenario: quickstart
settings: {fleet.size: 6}
duration_s: 2
axes:
  channel.loss.p: [0, 0.5]
  control.gains.k_v: {from: 0.2, to: 0.6, steps: 3}
seeds: 2
measures: [smallest_gap_m, fallbacks]
"""


def ranged(start: float, end: float, steps: int) -> Range:
    return Range.model_validate({"from": start, "to": end, "steps": steps})


# Axes.


@given(start=st.floats(-1e6, 1e6), end=st.floats(-1e6, 1e6), steps=st.integers(2, 50))
def test_a_range_has_both_ends_and_equal_distances(start: float, end: float, steps: int) -> None:
    axis = ranged(start, end, steps)
    values = axis.values_of("x")
    assert len(values) == axis.size == steps
    assert (values[0], values[-1]) == (start, end)
    distance = (end - start) / (steps - 1)
    for low, high in pairwise(values):
        assert high - low == pytest.approx(distance, abs=1e-5, rel=1e-5)


def test_a_range_of_whole_numbers_stays_whole() -> None:
    assert ranged(2, 10, 5).values_of("fleet.size") == [2, 4, 6, 8, 10]
    assert all(isinstance(value, int) for value in ranged(9, 0, 4).values_of("x"))
    assert ranged(0, 1, 3).values_of("x") == [0.0, 0.5, 1.0]
    assert ranged(0.1, 0.7, 3).values_of("x") == [0.1, 0.4, 0.7]  # not 0.39999999999999997


@given(seed=st.integers(0, 2**63 - 1), few=st.integers(1, 20), more=st.integers(0, 20))
def test_more_samples_keep_the_first(seed: int, few: int, more: int) -> None:
    def values(samples: int) -> list[Any]:
        axis = Normal(distribution="normal", mean=3, sd=2.0, samples=samples, seed=seed)
        return axis.values_of("control.gains.k_v")

    assert values(few + more)[:few] == values(few)


def test_axes_with_the_same_seed_draw_different_numbers() -> None:
    axis = Uniform(distribution="uniform", low=0, high=1, samples=50)
    assert axis.values_of("control.gains.k_v") != axis.values_of("control.gains.k_d")


def test_draws_have_their_distribution() -> None:
    n = 20_000
    uniform = Uniform(distribution="uniform", low=2, high=4, samples=n).values_of("x")
    assert 2.0 <= min(uniform) < 2.01
    assert 3.99 < max(uniform) <= 4.0
    assert sum(uniform) / n == pytest.approx(3.0, abs=0.02)
    normal = Normal(distribution="normal", mean=5, sd=2.0, samples=n).values_of("x")
    mean = sum(normal) / n
    assert mean == pytest.approx(5.0, abs=0.06)
    assert math.sqrt(sum((v - mean) ** 2 for v in normal) / n) == pytest.approx(2.0, abs=0.05)
    lognormal = Lognormal(distribution="lognormal", median=3.0, sigma=0.5, samples=n).values_of("x")
    logs = [math.log(value / 3.0) for value in lognormal]
    assert sum(logs) / n == pytest.approx(0.0, abs=0.02)
    assert math.sqrt(sum(v * v for v in logs) / n) == pytest.approx(0.5, abs=0.02)
    choice = Choice(distribution="choice", values=["a", "b", "c", "d"], samples=n).values_of("x")
    for value in "abcd":
        assert choice.count(value) / n == pytest.approx(0.25, abs=0.02)


def test_drawn_values_can_be_typed_again() -> None:
    values = Uniform(distribution="uniform", low=0, high=1, samples=100).values_of("x")
    assert all(len(f"{value:.6g}") <= 12 and float(f"{value:.6g}") == value for value in values)


# Plans.

AXES = st.lists(
    st.one_of(
        st.lists(st.integers(0, 99), min_size=1, max_size=4, unique=True).map(
            lambda values: Listed(values=values)
        ),
        st.just(Uniform(distribution="uniform", low=0, high=1, samples=3)),
    ),
    min_size=1,
    max_size=4,
)


@given(axes=AXES)
def test_points_are_all_combinations_with_random_axes_as_one(axes: list[Axis]) -> None:
    named = {f"a{number}": axis for number, axis in enumerate(axes)}
    points = list(points_of(named))
    assert len(points) == size_of(named)
    assert all(list(point) == list(named) for point in points)
    values = {key: axis.values_of(key) for key, axis in named.items()}
    random = [key for key, axis in named.items() if axis.random]
    for point in points:
        assert len({values[key].index(point[key]) for key in random}) <= 1
    assert len({tuple(point.items()) for point in points}) == len(points)


def test_the_last_axis_varies_fastest(tmp_path: Path) -> None:
    plan = plan_of(read_study(write_study(tmp_path, GOOD)))
    assert [tuple(cell.point.values()) for cell in plan.cells] == [
        (0, 0.2),
        (0, 0.4),
        (0, 0.6),
        (0.5, 0.2),
        (0.5, 0.4),
        (0.5, 0.6),
    ]
    assert [cell.number for cell in plan.cells] == [1, 2, 3, 4, 5, 6]
    assert plan.seeds == (1, 2)
    assert plan.runs == 12


def test_keys_equal_those_of_the_cells(tmp_path: Path) -> None:
    plan = plan_of(read_study(write_study(tmp_path, GOOD)))
    keys = [key for cell in plan.cells for key in cell.keys]
    assert len(set(keys)) == 12
    for cell in plan.cells:
        made = [plan.cell(cell, seed).key() for seed in plan.seeds]
        assert list(cell.keys) == made


def test_a_scenario_beside_the_study_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "mine.yaml").write_text("extends: quickstart\nfleet: {size: 7}\n")
    text = "scenario: mine.yaml\naxes: {fleet.size: [6, 7]}\n"
    path = write_study(tmp_path / "sub", text)
    monkeypatch.chdir(tmp_path)
    plan = plan_of(read_study(path))
    assert [plan.cell(cell, 1).load().scenario.fleet.size for cell in plan.cells] == [6, 7]


def test_a_mapping_may_be_a_study(tmp_path: Path) -> None:
    keys = {"scenario": "quickstart", "axes": {"channel.loss.p": [0, 0.5]}, "seeds": [3, 7]}
    plan = plan_of(read_study(keys))
    assert plan.seeds == (3, 7)
    text = "scenario: quickstart\naxes: {channel.loss.p: [0, 0.5]}\nseeds: [3, 7]\n"
    same = plan_of(read_study(write_study(tmp_path, text)))
    assert [cell.keys for cell in plan.cells] == [cell.keys for cell in same.cells]


# The folder.


def test_a_folder_with_other_files_is_refused_and_not_touched(tmp_path: Path) -> None:
    checked = read_study(write_study(tmp_path, GOOD))
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "precious.txt").write_text("thesis")
    with pytest.raises(ScenarioError, match=r"--out .*out: holds no study, but precious.txt; name"):
        open_store(folder, checked)
    assert [path.name for path in folder.iterdir()] == ["precious.txt"]
    with pytest.raises(ScenarioError, match="is a file, not a folder"):
        open_store(folder / "precious.txt", checked)


def test_a_folder_of_another_study_is_refused_and_not_touched(tmp_path: Path) -> None:
    open_store(tmp_path / "out", read_study(write_study(tmp_path, GOOD)))
    before = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    other = GOOD.replace("control.gains.k_v", "control.gains.k_d").replace("duration_s: 2", "")
    with pytest.raises(ScenarioError, match=r"holds another study \(axes, duration_s differ\)"):
        open_store(tmp_path / "out", read_study(write_study(tmp_path, other)))
    after = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert after == before


def test_a_study_may_grow(tmp_path: Path) -> None:
    open_store(tmp_path / "out", read_study(write_study(tmp_path, GOOD)))
    grown = GOOD.replace("seeds: 2", "seeds: 9").replace("[0, 0.5]", "[0, 0.5, 0.7]")
    open_store(tmp_path / "out", read_study(write_study(tmp_path, grown)))
    assert "seeds: 9" in (tmp_path / "out" / "study.yaml").read_text()
