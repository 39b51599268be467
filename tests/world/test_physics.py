"""The log of the paper's case 15 shows what the paper says of it (on arrays)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from zenvoy.analysis import read_fleet, summarize
from zenvoy.analysis.measures.metrics import min_distance
from zenvoy.links.distance import gaps

RING_M = 1_500.0


def run(folder: Path, *options: str) -> Path:
    command = [sys.executable, "-m", "zenvoy.cli", "run", "paper/case-15"]
    command += ["--engine", "arrays", "--out", str(folder), *options]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "run.mcap"


@pytest.fixture(scope="module")
def pbcm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("pbcm") / "run", "--duration-s", "110")


def test_pbcm_keeps_the_vehicles_apart(pbcm: Path) -> None:
    summary = summarize(pbcm)
    assert summary["collisions"] == 0
    assert 34.0 < summary["distance_m"]["before_braking"]["min"] < 37.0
    assert summary["distance_m"]["dip"]["min"] >= 32.0
    assert summary["distance_m"]["end"]["max"] <= 39.0
    assert summary["speed_spread_at_100_s_mps"] <= 0.2
    truth = read_fleet(pbcm)["/fleet/truth"]
    later = truth["time_ns"] >= 60_000_000_000
    assert min_distance(gaps(truth["position"][later], RING_M)).min() >= 36.0


def test_pbcm_estimates_better_than_it_reads(pbcm: Path) -> None:
    speed = summarize(pbcm)["speed"]
    # errors of readings are uniform up to 10 % of 30 m/s: 3 / sqrt(3) m/s
    assert speed["measured"]["rmse"] == pytest.approx(3.0 / 3**0.5, rel=0.02)
    assert speed["estimated"]["rmse"] <= 0.43 * speed["measured"]["rmse"]


def test_fm_collapses(tmp_path: Path) -> None:
    log = run(tmp_path / "run", "--set", "control.schedule.0.model=FM", "--duration-s", "300")
    truth = read_fleet(log)["/fleet/truth"]
    assert truth["time_ns"][-1] == 300_000_000_000
    assert np.count_nonzero(truth["speed"][-1] < 0.1) >= 40 / 3
    assert summarize(log)["collisions"] > 0
