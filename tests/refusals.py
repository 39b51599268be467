"""A helper returns the message with which a scenario is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from zenvoy.scenarios import InvalidScenarioError, ScenarioError, load

TOP = (
    "extends, description, duration_s, period_ms, clock, speed, max_clock_error_ms, seed, "
    "stall_limit_s, on_collision, on_vehicle_loss, public_truth, road, fleet, vehicle, control, "
    "beacons, sensors, estimator, channel, log, events, faults"
)
"""The keys of a scenario's top level, as messages name them."""


def refusal_of(
    path: str | Path,
    *settings: str,
    kind: type[ScenarioError] = InvalidScenarioError,
    seed: int | None = None,
    duration_s: float | None = None,
) -> str:
    """Return the message with which a scenario is refused: one line for each problem."""
    with pytest.raises(kind) as caught:
        load(path, settings, seed=seed, duration_s=duration_s)
    assert type(caught.value) is kind
    assert len(caught.value.problems) == len(str(caught.value).splitlines())
    return str(caught.value)
