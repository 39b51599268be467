"""Processes that the scenario kills, freezes or slows fail in real time as in lock-step."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fleet.realtime_agents.runs import MS, of, scenario
from tests.fleet.realtime_agents.test_equal_to_lock_step import DATA
from tests.virtual_time import in_lock_step, in_virtual_time
from zenvoy.vehicles.realtime import RealtimeVehicle

FAULTS = """
duration_s: 6
on_vehicle_loss: restart
fleet: {size: 7}
control: {model: PBCM, v2v_wait_ms: 50, system_delay_ms: 70}
channel: {loss: {p: 0.1}}
events: [{vehicle: 1, at_s: 3, duration_s: 1, deceleration_mps2: 2}]
faults:
  - {type: process-killed, vehicles: 3, at_s: 1.03, duration_s: 1.5}
  - {type: process-killed, vehicles: 3, at_s: 4, duration_s: 0.7}
  - {type: process-frozen, vehicles: 5-6, at_s: 2.5, duration_s: 2}
  - {type: process-slowed, vehicles: 2, at_s: 3, duration_s: 1, delay_ms: 330}
"""
LOSS = """
duration_s: 4
fleet: {size: 5}
control: {model: BCM, v2v_wait_ms: 50, system_delay_ms: 60}
faults: [{type: process-killed, vehicles: 3, at_s: 1.05, deceleration_mps2: 2}]
"""
SCENARIOS = {
    "restart": FAULTS,
    "decides on what is at hand": FAULTS.replace("v2v_wait_ms: 50", "v2v_wait_ms: 0"),
    "brake": f"{LOSS}on_vehicle_loss: brake\n",
    "coast": f"{LOSS}on_vehicle_loss: coast\n",
}


@pytest.mark.parametrize("text", SCENARIOS.values(), ids=SCENARIOS.keys())
def test_without_lateness_faults_in_real_time_equal_lock_step(tmp_path: Path, text: str) -> None:
    settings = scenario(tmp_path, text)
    realtime, stepped = in_virtual_time(settings), in_lock_step(settings)
    for topic in DATA:
        found, expected = of(topic, realtime), of(topic, stepped)
        if topic == "/events":  # fallbacks are noted when their cycle is logged, which is later
            found, expected = sorted(found), sorted(expected)
        assert found == expected, topic


def test_a_process_is_done_when_its_life_ends(tmp_path: Path) -> None:
    settings = scenario(tmp_path, FAULTS)
    first, last = RealtimeVehicle(settings, 3, 0), RealtimeVehicle(settings, 3, 2)
    assert (first.due_ns, last.due_ns) == (1_100 * MS, None)
    assert first.act(1_100 * MS) == []
    assert first.done
    assert not last.done
