"""The rehearsal before a fork runs whatever a scenario says of single vehicles."""

from __future__ import annotations

from tests.faults import scenario_with
from zenvoy.fleet.rehearsal import rehearse


def test_the_small_fleet_needs_no_vehicle_that_the_scenario_names() -> None:
    channel = {
        "outages": [{"source": "20"}],
        "rules": [{"destination": "18-20", "loss": {"p": 0.5}}],
    }
    faults = [{"type": "sensor-blind", "vehicles": "20", "at_s": 0.0}]
    rehearse(scenario_with(faults, size=20, duration_s=1.0, channel=channel))
