"""A sweep gives the same table on all engines, and also if a batch of runs fails."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from tests.studies.conftest import contents
from tests.studies.sweep_cases import STUDY
from zenvoy.studies.cell import Cell
from zenvoy.studies.sweeps import running
from zenvoy.studies.sweeps.sweep import run_sweep

BATCH = STUDY.replace("frames.lost, ", "").replace("[1, 4]", "[1, 4, 9]")


@pytest.fixture(scope="module")
def on_arrays(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("arrays")
    (folder / "loss.yaml").write_text(BATCH + "engine: arrays\n")
    outcome = zenvoy(folder, "sweep", "loss.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    return folder


def test_all_engines_give_the_same_table(on_arrays: Path, tmp_path: Path) -> None:
    (tmp_path / "loss.yaml").write_text(BATCH + "engine: in-process\n")
    assert zenvoy(tmp_path, "sweep", "loss.yaml", "--out", "out").code == 0
    summaries = [
        json.loads(path.read_text()) for path in (tmp_path / "out" / "runs").glob("*.json")
    ]
    assert all(summary["frames"] is not None for summary in summaries)
    batch = [json.loads(path.read_text()) for path in (on_arrays / "out" / "runs").glob("*.json")]
    assert all(summary["frames"] is None for summary in batch)
    for name in ("table.parquet", "series.parquet", "means.csv", "smallest_gap_m.svg"):
        alone = (tmp_path / "out" / name).read_bytes()
        assert (on_arrays / "out" / name).read_bytes() == alone, name


def test_missing_seeds_of_a_cell_are_run_on_arrays(on_arrays: Path, tmp_path: Path) -> None:
    (tmp_path / "loss.yaml").write_text(BATCH)
    for name, content in contents(on_arrays / "out").items():
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).write_bytes(content)
    for path in sorted((tmp_path / "out" / "runs").glob("*.json"))[:5]:
        path.unlink()
    outcome = zenvoy(tmp_path, "sweep", "loss.yaml", "--out", "out")
    assert outcome.out.startswith("4 cells × 3 seeds: 12 runs, 5 to do\n")
    table = (tmp_path / "out" / "table.parquet").read_bytes()
    assert table == (on_arrays / "out" / "table.parquet").read_bytes()


def test_a_measure_that_needs_a_log_repeats_old_runs(on_arrays: Path, tmp_path: Path) -> None:
    (tmp_path / "loss.yaml").write_text(STUDY.replace("[1, 4]", "[1]"))
    for name, content in contents(on_arrays / "out").items():
        (tmp_path / "out" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "out" / name).write_bytes(content)
    outcome = zenvoy(tmp_path, "sweep", "loss.yaml", "--out", "out")
    assert outcome.out.startswith("4 cells × 1 seed: 4 runs, 4 to do\n")
    rows = pyarrow.parquet.read_table(tmp_path / "out" / "table.parquet").to_pylist()
    assert all(row["frames.lost"] is not None for row in rows)


def test_a_batch_that_fails_is_repeated_run_by_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that runs seed 2 dies, as if it lacked memory, in a batch and alone."""
    kept = running.keep_runs

    def dies(cells: Sequence[Cell], *arguments: Any) -> None:
        if any(cell.seed == 2 for cell in cells):
            os.kill(os.getpid(), signal.SIGKILL)
        kept(cells, *arguments)

    monkeypatch.setattr("zenvoy.studies.sweeps.crew.keep_runs", dies)
    reported: list[str] = []
    keys = {
        "scenario": "quickstart",
        "settings": {"fleet.size": 6},
        "axes": {"channel.loss.p": [0.5]},
        "seeds": 3,
        "duration_s": 1,
    }
    done = run_sweep(keys, out=tmp_path / "o", jobs=1, on_line=reported.append, command="c")
    assert [row.failure for row in done.results.rows] == [
        None,
        "its process was killed by SIGKILL",
        None,
    ]
    assert reported == [
        "1 cell × 3 seeds: 3 runs, 3 to do",
        "1 of 3: channel.loss.p=0.5, seed 1",
        "2 of 3: channel.loss.p=0.5, seed 2 failed: its process was killed by SIGKILL",
        "3 of 3: channel.loss.p=0.5, seed 3",
    ]
