"""`zenvoy tune` finds the best trial, and writes its results."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import optuna
import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from tests.studies.conftest import FILES, GAP, rows_of
from zenvoy.analysis.measures.figures import figures
from zenvoy.scenarios import load
from zenvoy.studies import tune
from zenvoy.studies.study import StudyError


def test_a_known_optimum_is_found(tuned: Path) -> None:
    rows = rows_of(tuned / "out")
    assert [row["trial"] for row in rows] == list(range(1, 13))
    assert all(row["feasible"] and row["failure"] is None for row in rows)
    best = min(rows, key=lambda row: float(row["gap.measured.spread"]))
    assert best["control.desired_gap_m"] == pytest.approx(20.0, abs=1.0)
    table = pyarrow.parquet.read_table(tuned / "out" / "trials.parquet")
    units = {f.name: (f.metadata or {}).get(b"unit") for f in table.schema}
    assert units["control.desired_gap_m"] == units["gap.measured.spread"] == b"m"
    assert units["trial"] is None


def test_the_best_scenario_runs_as_it_stands(tuned: Path, tmp_path: Path) -> None:
    out = tuned / "out"
    best = min(rows_of(out), key=lambda row: float(row["gap.measured.spread"]))
    found = []
    for seed in ("1", "4"):
        arguments = ("out/best.yaml", "--seed", seed, "--out", str(tmp_path / seed))
        outcome = zenvoy(tuned, "run", *arguments, "--engine", "in-process")
        assert outcome.code == 0, outcome
        summary = json.loads((tmp_path / seed / "summary.json").read_text())
        found.append(figures(summary)["gap.measured.spread"])
    assert best["gap.measured.spread"] == sum(filter(None, found)) / 2
    assert "extends: quickstart\n" in (out / "best.yaml").read_text()
    assert load(out / "best.yaml").scenario.seed == 1


def test_the_folder_says_what_was_found(tuned: Path) -> None:
    out = tuned / "out"
    best = min(rows_of(out), key=lambda row: float(row["gap.measured.spread"]))
    page = (out / "README.md").read_text()
    assert "`zenvoy tune gap.yaml --out out`" in page
    assert "12 trials × 2 seeds of the scenario `quickstart`" in page
    assert "The gap at which nothing moves." in page
    assert f"**Trial {best['trial']} is the best**" in page
    assert f"- `control.desired_gap_m={best['control.desired_gap_m']}`" in page
    assert (out / "study.yaml").read_text() == GAP
    assert (out / "search.png").read_bytes().startswith(b"\x89PNG")
    assert {path.name for path in out.iterdir()} == {
        *FILES,
        "runs",
        "study.json",
        "study.yaml",
        "trials.db",
    }


def test_optuna_reads_the_trials(tuned: Path) -> None:
    """As its dashboard does."""
    storage = optuna.storages.RDBStorage(f"sqlite:///{tuned / 'out' / 'trials.db'}")
    study = optuna.load_study(study_name="zenvoy", storage=storage)
    values = [row["gap.measured.spread"] for row in rows_of(tuned / "out")]
    assert [trial.value for trial in study.trials] == values
    assert study.best_value == min(values)
    storage.remove_session()
    storage.engine.dispose()


def test_the_engines_give_the_same_trials(tuned: Path, tmp_path: Path) -> None:
    text = GAP.replace("trials: 12", "trials: 3") + "engine: in-process\n"
    (tmp_path / "gap.yaml").write_text(text)
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    assert rows_of(tmp_path / "out") == rows_of(tuned / "out")[:3]


def test_from_python_it_gives_the_same_table(tuned: Path) -> None:
    """In a process of its own, as the process of the tests may have threads."""
    script = """if True:
        from zenvoy.studies import tune
        lines = []
        frame = tune("gap.yaml", out="out", on_line=lines.append)
        assert lines == ["12 trials × 2 seeds, 0 to do"], lines
        assert frame.attrs["units"]["gap.measured.spread"] == "m"
        best = frame[frame["trial"] == frame.attrs["best"]]
        print(best["gap.measured.spread"].item() == frame["gap.measured.spread"].min())
    """
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tuned, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


@pytest.mark.parametrize(("package", "extra"), [("optuna", "tune"), ("pandas", "pandas")])
def test_a_missing_package_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, extra: str
) -> None:
    monkeypatch.setattr(
        "zenvoy.studies.extras.find_spec", lambda name: None if name == package else 1
    )
    with pytest.raises(StudyError, match=rf"{package} .*pip install 'zenvoy\[{extra}\]'"):
        tune({"scenario": "quickstart"}, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
