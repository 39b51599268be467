"""Fleets run with a lag and limits for each vehicle."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.conftest import run
from zenvoy.analysis.log.load import load

SCENARIO = """
duration_s: 20
road: {type: open}
fleet:
  size: 5
  groups:
    - {name: slow, vehicles: 3-4, vehicle: {actuator_lag_s: 0.8, max_deceleration_mps2: 0.6}}
    - {name: human, vehicles: 5, model: FM}
vehicle: {actuator_lag_s: 0.5}
sensors: {error: 0}
events:
  - {type: brake, vehicle: 1, at_s: 5, duration_s: 2, deceleration_mps2: 2}
"""


def test_all_engines_log_the_same(tmp_path: Path) -> None:
    logs = {
        engine: run(tmp_path / engine, SCENARIO, "--engine", engine)
        for engine in ("processes", "in-process", "arrays")
    }
    prints = {log.result["fingerprint"] for log in logs.values()}
    assert len(prints) == 1


def test_the_limits_and_the_lag_are_those_of_each_vehicle(tmp_path: Path) -> None:
    run(tmp_path / "r", SCENARIO, "--engine", "in-process")
    found = load(tmp_path / "r" / "out" / "run.mcap")
    commands, true = found.command["acceleration"], found.truth["acceleration"]
    lowest = commands.min(axis=0)
    assert lowest[1] < -0.6
    assert lowest[2] == -0.6
    # Without errors, only the lag keeps the acceleration from its command.
    assert np.abs(np.diff(true[:, 2])).max() < 3.0 * (1.0 - np.exp(-0.1 / 0.8))


def test_a_vehicle_that_knows_its_lag_predicts_better(tmp_path: Path) -> None:
    """It predicts its own speed to the effect of its command, here a cycle later."""
    run(tmp_path / "r", SCENARIO, "--engine", "in-process")
    found = load(tmp_path / "r" / "out" / "run.mcap")
    rows, vehicles = np.arange(50, 150), slice(1, 4)
    true = found.truth["speed"][:, vehicles]
    with_lag = found.estimate["predicted_speed"][rows, vehicles]
    without = true[rows] + 0.1 * found.command["acceleration"][rows - 1, vehicles]
    errors = [np.abs(predicted - true[rows + 1]).max() for predicted in (with_lag, without)]
    assert errors[0] < 0.01
    assert errors[1] > 5.0 * errors[0]
