"""Quantities of a log pair each reading and estimate with the truth of its own time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.agreement import agreement
from zenvoy.analysis.measures.quantities import quantities


def test_quantities_are_at_their_own_time(run: Run) -> None:
    found = {quantity.name: quantity for quantity in quantities(run)}
    assert list(found) == [
        "own speed",
        "gap ahead",
        "relative speed ahead",
        "gap behind",
        "relative speed behind",
    ]
    position, speed = run.truth["position"], run.truth["speed"]
    ring_m = 6 * 37.5
    estimate, behind = run.estimate, found["gap behind"]
    late = 0
    seen: set[tuple[int, int]] = set()
    for cycle in range(run.cycles):
        for vehicle in range(6):
            ahead = position[cycle, vehicle - 1] + (ring_m if vehicle == 0 else 0.0)
            gap = ahead - position[cycle, vehicle]
            follower = (vehicle - 1) % 6
            assert found["gap ahead"].true[cycle, vehicle] == gap
            change = speed[cycle, follower] - speed[cycle, vehicle]
            assert found["relative speed ahead"].true[cycle, vehicle] == change
            assert behind.true[cycle, follower] == gap
            assert behind.measured[cycle, follower] == run.radar["gap"][cycle, vehicle]
            of = estimate["behind_measured_ns"][cycle, vehicle] // run.scenario.period_ns
            late += of < cycle
            if of >= 0:
                seen.add((of, vehicle))
                assert behind.estimated[of, vehicle] == estimate["behind_gap"][cycle, vehicle]
                assert behind.std[of, vehicle] == estimate["behind_gap_std"][cycle, vehicle]
    assert late > 100  # frames come late, or not at all
    assert int((~np.isnan(behind.estimated)).sum()) == len(seen) < run.cycles * 6
    np.testing.assert_array_equal(found["gap ahead"].estimated, estimate["ahead_gap"])


def test_readings_have_the_stated_variance(run: Run) -> None:
    for quantity in quantities(run):
        share = (quantity.measured - quantity.true) / np.sqrt(quantity.reading_variance)
        assert float(share.std()) == pytest.approx(1.0, abs=0.05)
        assert np.abs(share).max() <= np.sqrt(3.0) + 1e-9  # uniform


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 6))
def test_each_vehicle_can_be_judged_separately(run: Run, vehicle: int) -> None:
    speed = quantities(run)[0]
    one = agreement(speed.estimated[:, vehicle - 1], speed.true[:, vehicle - 1])
    assert one is not None
    assert one.samples == run.cycles
    assert one.rmse < 1.0
