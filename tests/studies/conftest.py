"""Studies that several tests share, and what is in their folders."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow.parquet
import pytest

from tests.conftest import zenvoy
from zenvoy.scenarios import ScenarioError
from zenvoy.studies.sweeps.plan import plan_of
from zenvoy.studies.sweeps.study_file import read_study

# Nothing moves if the desired gap is the initial one: this is the optimum, and it is known.
GAP = """
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


def write_study(folder: Path, text: str) -> Path:
    """Write a study into a folder, and return its path."""
    path = folder / "study.yaml"
    path.write_text(text)
    return path


@pytest.fixture
def refusal_of_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], list[str]]:
    """Return a function that reads a study, which must be refused, and returns the lines."""
    monkeypatch.chdir(tmp_path)

    def read(text: str) -> list[str]:
        write_study(tmp_path, text)
        with pytest.raises(ScenarioError) as refused:
            plan_of(read_study("study.yaml"))
        return str(refused.value).splitlines()

    return read


@pytest.fixture(scope="module")
def tuned(folder: Path) -> Path:
    """Return a folder with the search GAP, which has its results in `out`."""
    (folder / "gap.yaml").write_text(GAP)
    outcome = zenvoy(folder, "tune", "gap.yaml", "--out", "out")
    assert (outcome.code, outcome.err) == (0, ""), outcome
    lines = outcome.out.splitlines()
    assert lines[0] == "12 trials × 2 seeds, 12 to do"
    assert lines[1].startswith("1 of 12: control.desired_gap_m=")
    assert set(lines[13:-1]) == {f"out/{name}" for name in FILES}
    assert lines[-1].startswith("best: trial ")
    return folder


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """Return the trials of a search."""
    rows: list[dict[str, Any]] = pyarrow.parquet.read_table(folder / "trials.parquet").to_pylist()
    return rows


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of each file in a folder, by its path."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def write_failing_law(folder: Path) -> None:
    """Write a scenario gap.yaml with a law that raises for time gaps above 1.5 s."""
    outcome = zenvoy(folder, "new", "law", "gap")
    assert outcome.code == 0, outcome
    law = (folder / "gap.py").read_text()
    line = "    error = seen.ahead.p"
    broken = """    if own.time_gap_s > 1.5 and seen.speed < 29.5:  # only once the leader brakes
        raise RuntimeError("too slow")
"""
    assert line in law
    (folder / "gap.py").write_text(law.replace(line, broken + line))
