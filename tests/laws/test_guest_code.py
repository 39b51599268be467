"""A vehicle that joins a run brings the code that the scenario names."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import command, wait_until, zenvoy
from zenvoy.analysis.log.load import load

CODE = """
from zenvoy.laws import Estimator, Law

def law(seen, own):
    if FAILS and seen.speed < 32.9:
        raise ValueError("too slow")
    return 0.5 * seen.ahead.v - 0.1

class Tracker:
    def __init__(self, model, z, R, own):
        pass
    def step(self, inputs, z, R):
        return z, R

LAW = Law(name="own", acceleration=law)
TRACKER = Estimator(name="own", start=Tracker)
"""
SCENARIO = """
duration_s: 3
stall_limit_s: 60
fleet: {size: 3, speed_mps: 33}
"""
OWN = {"law": "control.model=mine:LAW", "estimator": "estimator.kind=mine:TRACKER"}


@pytest.mark.parametrize("own", OWN)
def test_a_guest_runs_the_code_of_the_scenario(tmp_path: Path, own: str) -> None:
    (tmp_path / "mine.py").write_text(f"FAILS = False\n{CODE}")
    (tmp_path / "s.yaml").write_text(SCENARIO)
    run = ("run", "s.yaml", "--set", OWN[own])
    with command(tmp_path, *run, "--without", "2", "--out", "out") as started:
        wait_until((tmp_path / "out" / "connect.json").exists, "the run can be met")
        guest = ("vehicle", "--id", "2", "--run", "out", "--timeout-s", "60")
        refused = zenvoy(tmp_path, *guest)
        assert refused.code == 2
        assert refused.err.startswith(f"{own} mine:")
        joined = zenvoy(tmp_path, *guest, "--allow-code")
        assert (joined.code, joined.err) == (0, "")
        assert started.wait().code == 0
    alone = zenvoy(tmp_path, *run, "--bus", "in-process", "--out", "alone")
    assert alone.code == 0
    prints = {load(tmp_path / name / "run.mcap").fingerprint for name in ("out", "alone")}
    assert len(prints) == 1


def test_a_law_that_fails_in_a_guest_is_named_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(f"FAILS = True\n{CODE}")
    (tmp_path / "s.yaml").write_text(SCENARIO)
    (tmp_path / "only.yaml").write_text(
        "extends: s.yaml\nfleet: {groups: [{name: g, vehicles: '2', model: 'mine:LAW'}]}\n"
    )
    with command(tmp_path, "run", "only.yaml", "--without", "2", "--out", "out"):
        wait_until((tmp_path / "out" / "connect.json").exists, "the run can be met")
        joined = zenvoy(tmp_path, "vehicle", "--id", "2", "--run", "out", "--allow-code")
        assert joined.code == 3
        message = "law own raised ValueError: too slow (mine.py, line 7)"
        assert joined.err == f"vehicle-02: {message}\n"
