"""Tables of a log with numbers that no run can produce are damaged."""

from __future__ import annotations

import numpy as np

from zenvoy.analysis.log.plausible import fleet_fault


def test_a_command_that_never_came_in_real_time_is_no_damage() -> None:
    table = {"acceleration": np.array([[0.5, np.nan]]), "effective_ns": np.array([[5, -1]])}
    assert fleet_fault("/fleet/command", table, 2) is None


def test_a_missing_truth_is_damage() -> None:
    table = {"speed": np.array([[30.0, np.nan]])}
    assert fleet_fault("/fleet/truth", table, 2) == "speed holds a number that no run can produce"
