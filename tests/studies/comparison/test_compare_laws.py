"""`zenvoy compare-laws` runs laws with the same seeds, and finds how they differ."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from tests.conftest import zenvoy
from tests.studies.comparison.conftest import LAWS, compare, findings, table
from tests.studies.conftest import contents
from zenvoy.analysis.measures.figures import figures
from zenvoy.analysis.measures.summary import summarize
from zenvoy.studies import compare_laws
from zenvoy.studies.comparison.comparing import MEASURED, Comparing, run_comparison
from zenvoy.studies.comparison.picture import picture

LABELS = ("FM", "PBCM", "Smith", "Smith {headway_s: 0.9}")


def values(folder: Path, law: str, measure: str) -> list[float]:
    return [row[measure] for row in table(folder) if row["law"] == law]


def test_each_law_has_the_same_seeds(compared: Path) -> None:
    rows = table(compared)
    assert [(row["law"], row["seed"]) for row in rows] == [
        (law, seed) for law in LABELS for seed in (1, 2, 3, 4)
    ]
    assert list(rows[0])[4:] == list(MEASURED)
    assert all(row["failure"] is None for row in rows)


@pytest.mark.parametrize(
    ("label", "settings"),
    [
        ("PBCM", ["control.model=PBCM", "control.parameters={}"]),
        ("Smith", []),  # it keeps the parameters that the scenario gives it
        ("Smith {headway_s: 0.9}", ["control.parameters={headway_s: 0.9}"]),
    ],
)
def test_a_row_is_the_run_of_that_law_and_seed(
    compared: Path, tmp_path: Path, label: str, settings: list[str]
) -> None:
    options = [part for setting in settings for part in ("--set", setting)]
    arguments = ("--seed", "3", "--engine", "in-process", "--out", str(tmp_path / "o"))
    outcome = zenvoy(compared, "run", "s.yaml", *options, *arguments)
    assert outcome.code == 0, outcome
    expected = figures(summarize(tmp_path / "o" / "run.mcap"))
    (row,) = [one for one in table(compared) if (one["law"], one["seed"]) == (label, 3)]
    for measure in MEASURED:
        assert row[measure] == expected[measure], measure


def test_intervals_are_those_of_student_and_differences_are_paired(compared: Path) -> None:
    found = findings(compared)
    first = values(compared, "FM", "smallest_gap_m")
    for law in LABELS:
        own = values(compared, law, "smallest_gap_m")
        row = found["smallest_gap_m", law]
        low, high = stats.t.interval(0.95, 3, np.mean(own), stats.sem(own))
        assert float(row["mean"]) == pytest.approx(np.mean(own))
        assert float(row["half_interval"]) == pytest.approx((high - low) / 2.0)
        assert (row["unit"], row["seeds"]) == ("m", "4")
        if law == "FM":
            assert row["difference"] == row["half_interval_of_difference"] == ""
            continue
        paired = stats.ttest_rel(own, first).confidence_interval(0.95)
        middle, half = (paired.high + paired.low) / 2.0, (paired.high - paired.low) / 2.0
        assert float(row["difference"]) == pytest.approx(middle)
        assert float(row["half_interval_of_difference"]) == pytest.approx(half)


def test_the_folder_describes_the_comparison(compared: Path) -> None:
    out = compared / "out"
    page = (out / "README.md").read_text()
    assert "`zenvoy compare-laws s.yaml --law FM --law PBCM --law mylaws:smith" in page
    assert "4 laws × 4 seeds of the scenario `s.yaml`" in page
    assert '| Smith | `control.model="mylaws:smith"` |' in page
    for name in ("laws.png", "laws-speeds.png"):
        assert f"]({name})" in page
        assert (out / name).read_bytes().startswith(b"\x89PNG")
        assert (out / name).with_suffix(".svg").exists()


def test_the_written_study_is_the_same_sweep(compared: Path) -> None:
    shutil.copy(compared / "out" / "study.yaml", compared / "again.yaml")
    outcome = zenvoy(compared, "sweep", "again.yaml", "--out", "swept")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    swept, own = compared / "swept", compared / "out"
    assert (swept / "table.parquet").read_bytes() == (own / "table.parquet").read_bytes()
    assert (swept / "series.parquet").read_bytes() == (own / "series.parquet").read_bytes()


def test_a_comparison_goes_on_with_more_laws_and_seeds(compared: Path, tmp_path: Path) -> None:
    for name in ("s.yaml", "mylaws.py"):
        shutil.copy(compared / name, tmp_path)
    shutil.copytree(compared / "out", tmp_path / "out")
    (tmp_path / "out" / "laws.csv").unlink()
    outcome = compare(tmp_path, "--seeds", "4")
    assert outcome.out.startswith("4 cells × 4 seeds: 16 runs, 0 to do\n"), outcome
    assert contents(tmp_path / "out") == contents(compared / "out")
    outcome = compare(tmp_path, "--seeds", "5", laws=("FM", "BCM", "PBCM"))
    assert outcome.out.startswith("3 cells × 5 seeds: 15 runs, 7 to do\n"), outcome
    assert outcome.code == 0
    outcome = compare(tmp_path, "--seeds", "5", "--duration-s", "3")
    assert outcome.code == 2
    assert "holds another study (duration_s differ)" in outcome.err


def test_python_returns_the_figures_of_the_file(
    compared: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(compared)
    said: list[str] = []  # nothing is left to run, so no process is forked from this one
    frame = compare_laws(Path("s.yaml"), LAWS, seeds=[1, 2, 3, 4], out="out", on_line=said.append)
    assert said == ["4 cells × 4 seeds: 16 runs, 0 to do"]
    found = findings(compared)
    assert len(frame) == len(found) == 4 * 8
    for row in frame.to_dict("records"):
        assert row["mean"] == float(found[row["measure"], row["law"]]["mean"])


def test_the_picture_has_a_panel_per_measure_and_a_row_per_law_in_its_colour(
    compared: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(compared)
    asked = Comparing(scenario="s.yaml", laws=LAWS, seeds=4)
    done = run_comparison(asked, out=Path("out"), jobs=1, on_line=lambda _: None, command="c")
    shown = picture(done.comparison)
    assert shown is not None
    figure = shown.draw()
    differing = [name for name in MEASURED if len(set(map(str, columns(compared, name)))) > 1]
    assert len(figure.axes) == len(differing) >= 5
    first = figure.axes[0]
    assert first.get_title(loc="left") == "Smallest gap of the run, m"
    assert [label.get_text() for label in first.get_yticklabels()] == list(LABELS)
    points = [line for line in first.lines if line.get_marker() == "o"]
    assert [line.get_color() for line in points] == ["#000000", "#0072B2", "#CC79A7", "#D55E00"]
    means = [float(findings(compared)["smallest_gap_m", law]["mean"]) for law in LABELS]
    assert [float(np.asarray(line.get_xdata())[0]) for line in points] == pytest.approx(means)


def columns(folder: Path, measure: str) -> list[float]:
    return [row[measure] for row in table(folder)]
