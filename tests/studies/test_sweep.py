"""`zenvoy sweep` runs a study, writes its table, and resumes where it stopped."""

from __future__ import annotations

import importlib.util
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from tests.conftest import command, run, wait_until, zenvoy
from tests.studies.conftest import contents, write_failing_law
from tests.studies.sweep_cases import SCENARIO, STUDY
from zenvoy.analysis import load
from zenvoy.analysis.measures.figures import figures
from zenvoy.analysis.measures.statistics import mean_of
from zenvoy.analysis.measures.summary import summarize
from zenvoy.studies import sweep
from zenvoy.studies.study import StudyError


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "loss.yaml").write_text(STUDY)
    outcome = zenvoy(folder, "sweep", "loss.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    assert outcome.out.startswith("4 cells × 2 seeds: 8 runs, 8 to do\n")
    return folder


def test_the_table_has_the_measures_of_single_runs(swept: Path, tmp_path: Path) -> None:
    table = pyarrow.parquet.read_table(swept / "out" / "table.parquet")
    assert table.column_names[:5] == [
        "cell",
        "channel.loss.p",
        "control.gains.k_v",
        "seed",
        "failure",
    ]
    rows = table.to_pylist()
    assert [(row["cell"], row["seed"]) for row in rows] == [
        (cell, seed) for cell in (1, 2, 3, 4) for seed in (1, 4)
    ]
    assert all(row["failure"] is None for row in rows)
    (row,) = [r for r in rows if r["cell"] == 3 and r["seed"] == 4]
    assert (row["channel.loss.p"], row["control.gains.k_v"]) == (0.9, 0.3)
    run(tmp_path / "alone", SCENARIO, "--bus", "in-process")
    log = tmp_path / "alone" / "out" / "run.mcap"
    expected = figures(summarize(log))
    for name in table.column_names[5:]:
        assert row[name] == expected[name], name
    assert row["frames.lost"] > 0
    assert row["speed_spread_at_100_s_mps"] is None  # asked for, although no run is so long
    units = {f.name: (f.metadata or {}).get(b"unit") for f in table.schema}
    assert units["smallest_gap_m"] == b"m"
    assert units["speed.estimated.rmse"] == b"m/s"
    assert units["fallbacks"] is None
    series = pyarrow.parquet.read_table(swept / "out" / "series.parquet")
    assert series.num_rows == 8 * 31
    of_row = [r for r in series.to_pylist() if r["cell"] == 3 and r["seed"] == 4]
    alone = load(log)
    assert [r["time_s"] for r in of_row] == alone.time_s.tolist()
    assert np.array_equal([r["mean_speed_mps"] for r in of_row], alone.truth["speed"].mean(axis=1))


def test_the_folder_describes_the_sweep(swept: Path) -> None:
    out = swept / "out"
    page = (out / "README.md").read_text()
    assert "`zenvoy sweep loss.yaml --out out`" in page
    assert "4 cells × 2 seeds of the scenario `quickstart`" in page
    assert "Frames lost, against the gain of relative speed." in page
    assert (out / "study.yaml").read_text() == STUDY
    assert (out / "legend.csv").read_text().splitlines()[6] == (
        "smallest_gap_m,m,smallest gap of the run"
    )
    table = pyarrow.parquet.read_table(out / "table.parquet").to_pylist()
    mean = mean_of([row["smallest_gap_m"] for row in table if row["cell"] == 1])
    first = (out / "means.csv").read_text().splitlines()[1].split(",")
    assert first[:4] == ["1", "0", "0.3", "2"]
    assert float(first[4]) == pytest.approx(mean.mean)
    assert float(first[5]) == pytest.approx((mean.high - mean.low) / 2)
    drawn = {path.stem for path in out.glob("*.png")}
    assert drawn == {"smallest_gap_m", "speed.estimated.rmse", "fallbacks", "frames.lost"}
    assert {path.stem for path in out.glob("*.svg")} == drawn


def test_finished_runs_are_not_run_again(swept: Path) -> None:
    before = contents(swept / "out")
    outcome = zenvoy(swept, "sweep", "loss.yaml", "--out", "out")
    assert outcome.code == 0
    assert outcome.out.startswith("4 cells × 2 seeds: 8 runs, 0 to do\n")
    assert contents(swept / "out") == before


def test_a_stopped_sweep_goes_on_to_the_same_table(swept: Path, tmp_path: Path) -> None:
    (tmp_path / "loss.yaml").write_text(STUDY)
    arguments = ("sweep", "loss.yaml", "--out", "out", "--jobs", "1")
    runs = tmp_path / "out" / "runs"
    with command(tmp_path, *arguments) as sweeping:
        wait_until(lambda: len(list(runs.glob("[!.]*.json"))) >= 2, "two runs are done")
        sweeping.send_to_group(signal.SIGINT)
        outcome = sweeping.wait()
    assert (outcome.code, outcome.err) == (130, "interrupted; the finished runs are kept\n")
    done = len(list(runs.glob("[!.]*.json")))
    assert 2 <= done < 8
    assert not (tmp_path / "out" / "table.parquet").exists()
    outcome = zenvoy(tmp_path, *arguments)
    assert outcome.out.startswith(f"4 cells × 2 seeds: 8 runs, {8 - done} to do\n")
    for name in ("table.parquet", "series.parquet", "means.csv", "smallest_gap_m.svg"):
        assert (tmp_path / "out" / name).read_bytes() == (swept / "out" / name).read_bytes(), name


def test_a_damaged_run_is_made_again(swept: Path, tmp_path: Path) -> None:
    (tmp_path / "loss.yaml").write_text(STUDY)
    for name, content in contents(swept / "out").items():
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).write_bytes(content)
    first, second, *_ = sorted((tmp_path / "out" / "runs").glob("*.json"))
    first.write_bytes(first.read_bytes()[:100])
    second.with_suffix(".npz").unlink()
    outcome = zenvoy(tmp_path, "sweep", "loss.yaml", "--out", "out")
    assert outcome.out.startswith("4 cells × 2 seeds: 8 runs, 2 to do\n")
    table = (tmp_path / "out" / "table.parquet").read_bytes()
    assert table == (swept / "out" / "table.parquet").read_bytes()


def test_a_run_that_fails_is_reported_and_the_others_go_on(tmp_path: Path) -> None:
    write_failing_law(tmp_path)
    (tmp_path / "study.yaml").write_text("""
scenario: gap.yaml
duration_s: 13
axes: {control.parameters.time_gap_s: [1.2, 1.8]}
measures: [smallest_gap_m]
""")
    outcome = zenvoy(tmp_path, "sweep", "study.yaml", "--out", "out")
    assert outcome.code == 1
    assert outcome.err == "1 of 2 runs failed; see out/README.md\n"
    assert "seed 1 failed: " in outcome.out
    assert "too slow" in outcome.out
    rows = pyarrow.parquet.read_table(tmp_path / "out" / "table.parquet").to_pylist()
    assert rows[0]["failure"] is None
    assert rows[0]["smallest_gap_m"] > 0
    assert "too slow" in rows[1]["failure"]
    assert rows[1]["smallest_gap_m"] is None
    page = (tmp_path / "out" / "README.md").read_text()
    assert "**1 of 2 runs failed**" in page
    assert "too slow" in page
    again = zenvoy(tmp_path, "sweep", "study.yaml", "--out", "out")
    assert "2 runs, 1 to do" in again.out  # a failed run is tried again


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (STUDY.replace("fallbacks", "fallback"), "measures.2: unknown name 'fallback'; did you "),
        (STUDY.replace("loss.p", "los.p"), "channel.los: unknown key; did you mean 'loss'?"),
        (STUDY.replace("steps: 2", "steps: 1000000000"), "4,000,000,000 runs; allowed: at most"),
    ],
)
def test_a_bad_study_is_refused_in_one_line_and_leaves_no_files(
    tmp_path: Path, text: str, line: str
) -> None:
    (tmp_path / "study.yaml").write_text(text)
    outcome = zenvoy(tmp_path, "sweep", "study.yaml", "--out", "out")
    assert outcome.code == 2
    assert line in outcome.err
    assert outcome.err.count("\n") == 1
    assert outcome.out == ""
    assert not (tmp_path / "out").exists()


def test_the_folder_of_another_study_is_not_touched(swept: Path) -> None:
    before = contents(swept / "out")
    (swept / "other.yaml").write_text(STUDY.replace("scenario: quickstart", "scenario: heavy-loss"))
    outcome = zenvoy(swept, "sweep", "other.yaml", "--out", "out")
    assert outcome.code == 2
    assert outcome.err == (
        "--out out: holds another study (scenario differ); name a new folder or an empty one\n"
    )
    assert contents(swept / "out") == before


def test_from_python_it_gives_the_same_table(swept: Path) -> None:
    """The sweep has its own process, since the process of the tests may have threads."""
    script = """if True:
        from zenvoy.studies import sweep
        lines = []
        frame = sweep("loss.yaml", out="out", on_line=lines.append)
        assert lines == ["4 cells × 2 seeds: 8 runs, 0 to do"], lines
        assert frame.attrs["units"]["smallest_gap_m"] == "m"
        print(frame.groupby("channel.loss.p")["frames.lost"].mean().to_dict())
    """
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=swept, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    table = pyarrow.parquet.read_table(swept / "out" / "table.parquet").to_pylist()
    lost = [row["frames.lost"] for row in table if row["channel.loss.p"] == 0.9]
    assert done.stdout == f"{{0.0: 0.0, 0.9: {sum(lost) / 4}}}\n"


def test_without_pandas_the_error_names_the_missing_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "zenvoy.studies.extras.find_spec",
        lambda name: None if name == "pandas" else find(name),
    )
    with pytest.raises(StudyError, match=r"pip install 'zenvoy\[pandas\]'"):
        sweep({"scenario": "quickstart"}, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
