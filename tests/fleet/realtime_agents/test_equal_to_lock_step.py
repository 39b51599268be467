"""Without lateness, real time equals lock-step bit for bit."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fleet.realtime_agents.runs import LATE_AND_LOST, of, scenario
from tests.virtual_time import in_lock_step, in_virtual_time

DATA = (
    "/fleet/truth",
    "/fleet/radar",
    "/fleet/estimate",
    "/fleet/command",
    "/v2v/frames",
    "/events",
)
SCENARIOS = {
    "late and lost frames": LATE_AND_LOST,
    "deciding on what is at hand": """
duration_s: 4
fleet: {size: 4}
control: {v2v_wait_ms: 0, system_delay_ms: 60}
channel: {loss: {p: 0.1}}
""",
    "out of range of most on the open road": """
duration_s: 4
road: {type: open}
fleet: {size: 5}
control: {beacon_age_limit_ms: 150}
channel: {technology: 5g-mmwave, loss: {p: 0.3}}
""",
    "second copies over a medium with carrier sense": """
duration_s: 3
fleet: {size: 8}
control: {v2v_wait_ms: 30, system_delay_ms: 70}
channel: {medium: {access: csma}, duplicate: 0.2}
""",
    "frames that others pass on": """
duration_s: 3
road: {type: open}
fleet: {size: 8, gap_m: 400}
control: {model: MBCM, v2v_wait_ms: 60}
channel: {relay_hops: 3, loss: {p: 0.1}}
""",
    "many neighbours": """
duration_s: 3
fleet: {size: 7, groups: [{name: deaf, vehicles: '2', beacons: false}]}
control: {model: MBCM, system_delay_ms: 230}
""",
}


@pytest.mark.parametrize("text", SCENARIOS.values(), ids=SCENARIOS.keys())
def test_without_lateness_real_time_equals_lock_step_bit_for_bit(tmp_path: Path, text: str) -> None:
    settings = scenario(tmp_path, text)
    realtime, stepped = in_virtual_time(settings), in_lock_step(settings)
    for topic in DATA:
        found, expected = of(topic, realtime), of(topic, stepped)
        assert [at for at, _ in found] == [at for at, _ in expected], topic
        assert found == expected, topic
    assert len(of("/realtime", realtime)) == settings.cycles
