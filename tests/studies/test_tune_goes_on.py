"""`zenvoy tune` resumes where it stopped, in the folder of the same study and in no other."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import command, wait_until, zenvoy
from tests.studies.conftest import GAP, contents, rows_of
from zenvoy.scenarios import ScenarioError, load
from zenvoy.studies.tuning.folder import held
from zenvoy.studies.tuning.tune import run_tune


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
    study.write_text(GAP.replace("trials: 12", "trials: 500"))
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
    study.write_text(GAP)
    outcome = zenvoy(tmp_path, *arguments)
    assert outcome.code == 0, outcome
    missing = int(outcome.out.splitlines()[0].split()[-3])
    assert missing <= 10
    for name in ("trials.parquet", "best.yaml", "search.svg", "parameters.svg"):
        assert (tmp_path / "out" / name).read_bytes() == (tuned / "out" / name).read_bytes(), name


def test_more_trials_continue_a_search(tuned: Path, tmp_path: Path) -> None:
    (tmp_path / "gap.yaml").write_text(GAP.replace("trials: 12", "trials: 4"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    assert len(rows_of(tmp_path / "out")) == 4
    (tmp_path / "gap.yaml").write_text(GAP)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.out.startswith("12 trials × 2 seeds, 8 to do\n")
    table = (tmp_path / "out" / "trials.parquet").read_bytes()
    assert table == (tuned / "out" / "trials.parquet").read_bytes()
    (tmp_path / "gap.yaml").write_text(GAP.replace("trials: 12", "trials: 4"))  # fewer again
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.out.startswith("4 trials × 2 seeds, 0 to do\n")
    assert rows_of(tmp_path / "out") == rows_of(tuned / "out")[:4]


def test_choices_may_be_lists_and_mappings(tmp_path: Path) -> None:
    """They are the same after a stop, and in the scenario of the best trial."""
    brake = {"vehicle": 2, "at_s": 0.1, "duration_s": 0.1, "deceleration_mps2": 3}
    keys = {
        "scenario": "quickstart",
        "settings": {"fleet.size": 4},
        "duration_s": 0.3,
        "parameters": {
            "channel.loss": {"choices": [{"p": 0.1}, {"p": 0.5}]},
            "events": {"choices": [[], [brake]]},
        },
        "minimize": "gap.measured.rmse",
    }
    for out, trials in (("a", 2), ("a", 4), ("b", 4)):
        done = run_tune(
            {**keys, "trials": trials}, out=tmp_path / out, jobs=1, on_line=print, command="c"
        )
    assert rows_of(tmp_path / "a") == rows_of(tmp_path / "b")
    assert done.best is not None
    best = load(tmp_path / "a" / "best.yaml").scenario
    assert {"p": best.channel.loss.p} == done.best.point["channel.loss"]
    assert len(best.events) == len(done.best.point["events"])


def test_a_trial_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    """A process dies at each SQL statement and at the commit of the write, in turn.

    The test has its own process, since the process of the tests may have threads.
    """
    script = """if True:
        import os, shutil
        from pathlib import Path
        from sqlalchemy import Engine, event
        from zenvoy.studies.tuning.reading import read_tune_study
        from zenvoy.studies.tuning.storage import Trials
        from zenvoy.studies.tuning.trial import Trial
        study = read_tune_study({
            "scenario": "quickstart",
            "parameters": {"control.gains.k_v": {"low": 0, "high": 1}},
            "minimize": "gap.measured.rmse",
            "constraints": {"collisions": {"max": 0}},
        })
        figures = {"gap.measured.rmse": (0.5, 0.7), "collisions": (0.0, 1.0)}
        trial = Trial(number=1, point={"control.gains.k_v": 0.25}, figures=figures)
        Path("new").mkdir()
        Trials(Path("new"), study)
        code, deaths = 9, 0
        while code:
            assert code == 9, code
            folder = Path(shutil.copytree("new", str(deaths)))
            child = os.fork()
            if not child:
                trials, happened = Trials(folder, study), []
                def die(*_):
                    happened.append(1)
                    if len(happened) > deaths:
                        os._exit(9)
                for moment in ("before_cursor_execute", "commit"):
                    event.listen(Engine, moment, die)
                trials.add(trial)
                os._exit(0)
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            found = Trials(folder, study).finished
            assert found in ([], [trial]), found
            deaths += bool(code)
        assert found == [trial]
        assert deaths > 3, deaths
    """
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_the_folder_of_another_study_is_left(tuned: Path) -> None:
    before = contents(tuned / "out")
    (tuned / "other.yaml").write_text(GAP.replace("high: 30", "high: 40"))
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
    (tmp_path / "gap.yaml").write_text(GAP)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err.startswith("--out out: holds another study (")


def test_a_scenario_that_has_changed_is_another_study(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text("extends: quickstart\n")
    text = GAP.replace("scenario: quickstart", "scenario: base.yaml")
    (tmp_path / "gap.yaml").write_text(text.replace("trials: 12", "trials: 1"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    (tmp_path / "base.yaml").write_text("extends: quickstart\nperiod_ms: 50\n")
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert "holds another study (content of the scenario differ);" in outcome.err


def test_a_damaged_database_is_refused(tmp_path: Path) -> None:
    (tmp_path / "gap.yaml").write_text(GAP.replace("trials: 12", "trials: 1"))
    assert zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out").code == 0
    (tmp_path / "out" / "trials.db").write_bytes(b"no database" * 100)
    outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err.startswith("out/trials.db: cannot be read: ")
    assert outcome.err.count("\n") == 1


def test_a_folder_is_for_one_search_at_a_time(tmp_path: Path) -> None:
    refused = pytest.raises(ScenarioError, match="another zenvoy tune is at work")
    with held(tmp_path), refused, held(tmp_path):
        pass
    with held(tmp_path):  # the end of the other one has freed it
        pass


def test_a_second_search_is_refused_and_changes_nothing(tuned: Path, tmp_path: Path) -> None:
    out = tuned / "out"
    before = contents(out)
    (tmp_path / "gap.yaml").write_text(GAP.replace("trials: 12", "trials: 13"))
    with held(out):
        outcome = zenvoy(tmp_path, "tune", "gap.yaml", "--out", str(out))
    assert outcome.code == 2
    assert outcome.err == f"--out {out}: another zenvoy tune is at work there; wait for its end\n"
    assert contents(out) == before


@pytest.mark.parametrize("name", ["a?b=c#d", "100 % {x}", "Zügé"])
def test_a_folder_may_have_any_name(tmp_path: Path, name: str) -> None:
    keys = {
        "scenario": "quickstart",
        "settings": {"road.type": "open"},
        "parameters": {"control.gains.k_v": {"low": 0.1, "high": 1.0}},
        "minimize": "head_to_tail_gain",
        "trials": 1,
    }
    for line in ("1 trial × 1 seed, 1 to do", "1 trial × 1 seed, 0 to do"):
        told: list[str] = []
        run_tune(keys, out=tmp_path / name, jobs=1, on_line=told.append, command="c")
        assert told[0] == line
    assert (tmp_path / name / "trials.db").is_file()
    assert [path.name for path in tmp_path.iterdir()] == [name]
