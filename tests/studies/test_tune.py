"""`zenvoy tune`: what it finds, keeps and writes, and that it goes on where it stopped."""

from __future__ import annotations

import json
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import optuna
import pyarrow.parquet
import pytest

from tests.conftest import command, wait_until, zenvoy
from zenvoy.analysis.measures.figures import figures
from zenvoy.analysis.theory.of_scenario import head_to_tail_gain
from zenvoy.scenarios import load
from zenvoy.studies import tune
from zenvoy.studies.study import StudyError
from zenvoy.studies.tuning.tune import run_tune

# Nothing moves if the desired gap is the initial one: this is the optimum, and it is known.
STUDY = """
scenario: quickstart
description: The gap at which nothing moves.
settings:
  fleet: {size: 4, gap_m: 20}
  road: {type: open}
  control: {model: FM}
  sensors: {error: 0}
  events: []
duration_s: 3
parameters:
  control.desired_gap_m: {low: 10, high: 30}
minimize: gap.measured.spread
seeds: [1, 4]
trials: 12
"""
STABLE = """
scenario: quickstart
settings: {fleet.size: 5, road.type: open, control.model: FM}
duration_s: 2
parameters:
  control.gains.k_v: {low: 0.1, high: 3}
  control.gains.k_c: {low: 0.01, high: 1, log: true}
maximize: smallest_gap_m
constraints: {head_to_tail_gain: {max: 1}}
trials: 12
"""
FILES = {
    "README.md",
    "best.yaml",
    "legend.csv",
    "parameters.png",
    "parameters.svg",
    "search.png",
    "search.svg",
    "trials.parquet",
}


def rows_of(folder: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pyarrow.parquet.read_table(folder / "trials.parquet").to_pylist()
    return rows


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def tuned(folder: Path) -> Path:
    (folder / "gap.yaml").write_text(STUDY)
    outcome = zenvoy(folder, "tune", "gap.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    lines = outcome.out.splitlines()
    assert lines[0] == "12 trials × 2 seeds, 12 to do"
    assert lines[1].startswith("1 of 12: control.desired_gap_m=")
    assert set(lines[13:-1]) == {f"out/{name}" for name in FILES}
    assert lines[-1].startswith("best: trial ")
    return folder


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
    assert (out / "study.yaml").read_text() == STUDY
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


def test_what_is_there_is_not_tried_again(tuned: Path) -> None:
    before = contents(tuned / "out")
    outcome = zenvoy(tuned, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 0
    assert outcome.out.startswith("12 trials × 2 seeds, 0 to do\n")
    assert contents(tuned / "out") == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_search_goes_on_to_the_same_trials(
    tuned: Path, tmp_path: Path, number: signal.Signals
) -> None:
    """It is stopped early in a search that is longer, which then is as long as the whole one."""
    study = tmp_path / "gap.yaml"
    study.write_text(STUDY.replace("trials: 12", "trials: 500"))
    arguments = ("tune", "gap.yaml", "--out", "out", "--jobs", "1")
    runs = tmp_path / "out" / "runs"
    with command(tmp_path, *arguments) as tuning:
        wait_until(lambda: len(list(runs.glob("[!.]*.json"))) >= 5, "two trials are done")
        if number == signal.SIGINT:
            tuning.send_to_group(number)
            outcome = tuning.wait()
            assert (outcome.code, outcome.err) == (
                130,
                "interrupted; the finished trials are kept\n",
            )
        else:
            tuning.send(number)
            tuning.wait()
    assert not (tmp_path / "out" / "trials.parquet").exists()
    study.write_text(STUDY)
    outcome = zenvoy(tmp_path, *arguments)
    assert outcome.code == 0, outcome
    missing = int(outcome.out.splitlines()[0].split()[-3])
    assert missing <= 10
    for name in ("trials.parquet", "best.yaml", "search.svg", "parameters.svg"):
        assert (tmp_path / "out" / name).read_bytes() == (tuned / "out" / name).read_bytes(), name


def test_more_trials_continue_a_search(tuned: Path, tmp_path: Path) -> None:
    (tmp_path / "gap.yaml").write_text(STUDY.replace("trials: 12", "trials: 4"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    assert len(rows_of(tmp_path / "out")) == 4
    (tmp_path / "gap.yaml").write_text(STUDY)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.out.startswith("12 trials × 2 seeds, 8 to do\n")
    table = (tmp_path / "out" / "trials.parquet").read_bytes()
    assert table == (tuned / "out" / "trials.parquet").read_bytes()


def test_a_string_stays_stable(tmp_path: Path) -> None:
    """A trial that theory rules out is not run, and the others have the gain that theory says."""
    (tmp_path / "stable.yaml").write_text(STABLE)
    outcome = zenvoy(tmp_path, "tune", "stable.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    rows = rows_of(tmp_path / "out")
    for row in rows:
        settings = [f"{key}={row[key]}" for key in ("control.gains.k_v", "control.gains.k_c")]
        base = ("fleet.size=5", "road.type=open", "control.model=FM")
        expected = head_to_tail_gain(load("quickstart", (*base, *settings)).scenario)
        assert row["head_to_tail_gain"] == expected
        assert row["feasible"] == (expected <= 1.0)
        assert (row["smallest_gap_m"] is None) == (expected > 1.0)
    feasible = [row for row in rows if row["feasible"]]
    assert 0 < len(feasible) < len(rows)
    runs = list((tmp_path / "out" / "runs").glob("*.json"))
    assert len(runs) == len(feasible)
    assert outcome.out.count(": ruled out: head_to_tail_gain ") == len(rows) - len(feasible)
    best = max(feasible, key=lambda row: float(row["smallest_gap_m"]))
    assert f"best: trial {best['trial']}: " in outcome.out
    assert head_to_tail_gain(load(tmp_path / "out" / "best.yaml").scenario) == 1.0


def test_every_seed_must_hold_a_measured_constraint(tmp_path: Path) -> None:
    """The limit is between what two seeds measure, so no trial is feasible."""
    keys = {
        "scenario": "quickstart",
        "settings": {"fleet.size": 5, "control.model": "BCM"},
        "duration_s": 2,
        "parameters": {"control.gains.k_v": {"low": 0.4, "high": 0.401}},
        "minimize": "gap.measured.rmse",
        "seeds": 2,
        "trials": 1,
    }
    done = run_tune(keys, out=tmp_path / "a", jobs=1, on_line=lambda _: None, command="c")
    values = done.trials[0].figures["gap.measured.rmse"]
    assert values[0] != values[1]
    limits = {"gap.measured.rmse": {"max": sum(values) / 2}}
    told: list[str] = []
    out = tmp_path / "b"
    done = run_tune(
        {**keys, "constraints": limits}, out=out, jobs=1, on_line=told.append, command="c"
    )
    assert done.best is None
    assert rows_of(out)[0]["gap.measured.rmse.max"] == max(values)
    assert f", but gap.measured.rmse {max(values):.6g} is above " in told[1]


def test_no_feasible_trial_is_told_and_the_results_are_kept(tmp_path: Path) -> None:
    limit = "constraints: {smallest_gap_m: {min: 1000}}\n"
    (tmp_path / "gap.yaml").write_text(STUDY.replace("trials: 12", "trials: 2") + limit)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 1
    assert outcome.err == "no trial is feasible; see out/README.md\n"
    assert "**No trial is feasible.**" in (tmp_path / "out" / "README.md").read_text()
    assert not (tmp_path / "out" / "best.yaml").exists()
    assert [row["feasible"] for row in rows_of(tmp_path / "out")] == [False, False]


def test_a_trial_that_fails_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    outcome = zenvoy(tmp_path, "new", "law", "gap")
    assert outcome.code == 0, outcome
    law = (tmp_path / "gap.py").read_text()
    line = "    error = seen.ahead.p"
    broken = """    if own.time_gap_s > 1.5 and seen.speed < 29.5:  # only once the leader brakes
        raise RuntimeError("too slow")
"""
    assert line in law
    (tmp_path / "gap.py").write_text(law.replace(line, broken + line))
    (tmp_path / "study.yaml").write_text("""
scenario: gap.yaml
duration_s: 13
parameters: {control.parameters.time_gap_s: {choices: [1.2, 1.8]}}
maximize: smallest_gap_m
trials: 6
""")
    outcome = zenvoy(tmp_path, "tune", "study.yaml", "--out", "out")
    rows = rows_of(tmp_path / "out")
    failed = [row for row in rows if row["failure"]]
    assert outcome.code == 1
    assert outcome.err == f"{len(failed)} of 6 trials failed; see out/README.md\n"
    assert {row["control.parameters.time_gap_s"] for row in failed} == {1.8}
    assert all("too slow" in row["failure"] and not row["feasible"] for row in failed)
    assert {row["control.parameters.time_gap_s"] for row in rows if row["feasible"]} == {1.2}
    assert ": failed: seed 1: " in outcome.out
    assert "too slow" in (tmp_path / "out" / "README.md").read_text()
    best = zenvoy(tmp_path, "run", "out/best.yaml", "--out", "alone", "--engine", "auto")
    assert best.code == 0, best  # the law lies beside the scenario that it extends


COLLIDING = """
scenario: quickstart
settings:
  fleet: {size: 4, gap_m: 8}
  control: {model: FM, desired_gap_m: 8}
  on_collision: stop
  events: [{vehicle: 2, at_s: 1, duration_s: 3, deceleration_mps2: 8}]
duration_s: 6
parameters: {control.gains.k_v: {low: 0.01, high: 0.02}}
maximize: smallest_gap_m
trials: 1
"""


def test_a_run_that_a_collision_stops_has_failed(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(COLLIDING)
    outcome = zenvoy(tmp_path, "tune", "study.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (1, "no trial is feasible; see out/README.md\n")
    assert ": failed: seed 1: stopped at " in outcome.out
    assert " s by a collision" in rows_of(tmp_path / "out")[0]["failure"]


def test_a_constraint_on_collisions_rules_it_out(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(COLLIDING + "constraints: {collisions: {max: 0}}\n")
    outcome = zenvoy(tmp_path, "tune", "study.yaml", "--out", "out")
    assert ": ruled out: collisions 1 is above 0\n" in outcome.out
    (row,) = rows_of(tmp_path / "out")
    assert (row["failure"], row["collisions.max"], row["smallest_gap_m"]) == (None, 1, None)


def test_the_engines_give_the_same_trials(tuned: Path, tmp_path: Path) -> None:
    text = STUDY.replace("trials: 12", "trials: 3") + "engine: in-process\n"
    (tmp_path / "gap.yaml").write_text(text)
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    assert rows_of(tmp_path / "out") == rows_of(tuned / "out")[:3]


def test_the_folder_of_another_study_is_left(tuned: Path) -> None:
    before = contents(tuned / "out")
    (tuned / "other.yaml").write_text(STUDY.replace("high: 30", "high: 40"))
    outcome = zenvoy(tuned, "tune", "other.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err == (
        "--out out: holds another study (parameters differ); name a new folder or an empty one\n"
    )
    assert contents(tuned / "out") == before


def test_the_folder_of_a_sweep_is_left(tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text(
        "scenario: quickstart\nduration_s: 1\naxes: {fleet.size: [5]}\n"
    )
    assert zenvoy(tmp_path, "sweep", "sweep.yaml", "--out", "out").code == 0
    (tmp_path / "gap.yaml").write_text(STUDY)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err.startswith("--out out: holds another study (")


def test_a_scenario_that_has_changed_is_another_study(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("extends: quickstart\n")
    text = STUDY.replace("scenario: quickstart", "scenario: base.yaml")
    (tmp_path / "gap.yaml").write_text(text.replace("trials: 12", "trials: 1"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    (tmp_path / "base.yaml").write_text("extends: quickstart\nperiod_ms: 50\n")
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert "holds another study (content of the scenario differ);" in outcome.err


def test_a_damaged_database_is_refused(tmp_path: Path) -> None:
    (tmp_path / "gap.yaml").write_text(STUDY.replace("trials: 12", "trials: 1"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    (tmp_path / "out" / "trials.db").write_bytes(b"no database" * 100)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err.startswith("out/trials.db: cannot be read: ")
    assert outcome.err.count("\n") == 1


def test_a_trial_is_written_whole_or_not_at_all(tuned: Path) -> None:
    """Whatever the moment at which the process dies: SQLite undoes what was not committed."""
    with sqlite3.connect(tuned / "out" / "trials.db") as database:
        states = database.execute("SELECT DISTINCT state FROM trials").fetchall()
    assert states == [("COMPLETE",)]


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
        "zenvoy.studies.tuning.frame.find_spec", lambda name: None if name == package else 1
    )
    with pytest.raises(StudyError, match=rf"{package} .*pip install 'zenvoy\[{extra}\]'"):
        tune({"scenario": "quickstart"}, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
