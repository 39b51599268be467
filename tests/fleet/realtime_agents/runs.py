"""Helpers give scenarios of runs in real time, and the messages of one topic in what a run logs."""

from __future__ import annotations

from pathlib import Path

from tests.virtual_time import Logged
from zenvoy.scenarios import Scenario, load

MS = 1_000_000
LATE_AND_LOST = """
duration_s: 6
fleet: {size: 5}
control: {model: FM, schedule: [{at_s: 2, model: PBCM}], v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {gilbert_elliott: {p: 0.1, r: 0.3}}}
events: [{vehicle: 3, at_s: 4, duration_s: 1, deceleration_mps2: 3}]
"""
QUIET = """
duration_s: 4
fleet: {size: 4}
control: {model: BCM, v2v_wait_ms: 20, system_delay_ms: 80}
"""


def scenario(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


def of(topic: str, logged: Logged) -> list[tuple[int, bytes]]:
    return [(time_ns, payload) for name, time_ns, payload in logged if name == topic]
