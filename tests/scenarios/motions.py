"""Runs scenarios in one process, and returns how their vehicles move."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.scenarios.test_library import run
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.topics import EVENTS, TRUTH
from zenvoy.scenarios import Scenario, load

S_NS = 1_000_000_000


def scenario_of(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


def motion(scenario: Scenario) -> tuple[Any, Any, list[pb.Event]]:
    """Return positions (T, n), speeds (T, n) and events of a run in one process."""
    log = run(scenario)
    truth = [pb.FleetTruth.FromString(data) for data in log[TRUTH]]
    events = [pb.Event.FromString(data) for data in log.get(EVENTS, [])]
    position, speed = (
        np.array([getattr(row, of) for row in truth]) for of in ("position", "speed")
    )
    return position, speed, events
