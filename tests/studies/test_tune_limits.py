"""`zenvoy tune` rules out trials that break a constraint, and reports those that fail."""

from __future__ import annotations

from pathlib import Path

from tests.conftest import zenvoy
from tests.studies.conftest import GAP, rows_of, write_failing_law
from zenvoy.analysis.theory.of_scenario import head_to_tail_gain
from zenvoy.scenarios import load
from zenvoy.studies.tuning.study import Constraint
from zenvoy.studies.tuning.tune import run_tune

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
    (tmp_path / "gap.yaml").write_text(GAP.replace("trials: 12", "trials: 2") + limit)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 1
    assert outcome.err == "no trial is feasible; see out/README.md\n"
    assert "**No trial is feasible.**" in (tmp_path / "out" / "README.md").read_text()
    assert not (tmp_path / "out" / "best.yaml").exists()
    assert [row["feasible"] for row in rows_of(tmp_path / "out")] == [False, False]


def test_a_trial_that_fails_is_told_and_the_rest_goes_on(tmp_path: Path) -> None:
    write_failing_law(tmp_path)
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


def test_a_search_in_theory_alone_runs_nothing(tmp_path: Path) -> None:
    keys = {
        "scenario": "quickstart",
        "settings": {"road.type": "open", "control.model": "FM", "fleet.size": 5},
        "parameters": {"control.gains.k_v": {"low": 0.1, "high": 3}},
        "minimize": "head_to_tail_gain",
        "trials": 8,
    }
    done = run_tune(keys, out=tmp_path / "o", jobs=1, on_line=lambda _: None, command="c")
    gains = [trial.figures["head_to_tail_gain"][0] for trial in done.trials]
    assert done.best is not None
    assert done.best.objective(done.study) == min(gains)
    assert list((tmp_path / "o" / "runs").iterdir()) == []


def test_the_worst_seed_decides() -> None:
    most = Constraint(figure="collisions", bound="max", limit=1)
    assert (most.worst((0.0, 2.0)), most.excess((0.0, 2.0))) == (2.0, 1.0)
    least = Constraint(figure="smallest_gap_m", bound="min", limit=5)
    assert (least.worst((7.0, 4.0)), least.excess((7.0, 4.0))) == (4.0, 1.0)
    assert least.excess((7.0, 5.0)) == 0.0
    assert (str(most), str(least)) == ("collisions ≤ 1", "smallest_gap_m ≥ 5")
