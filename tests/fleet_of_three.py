"""A fleet for tests of wrong messages, and valid messages of one of its cycles."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from zenvoy.bus import messages_pb2 as pb
from zenvoy.scenarios import Scenario, load

SIZE: Final = 3
FLEET: Final = """
fleet: {size: 3}
control: {v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""
MOST_LINES: Final = 22  # 20 kinds and sources, a line that there are more, and the counts
K: Final = 5  # the cycle
T_NS: Final = 100_000_000
AT: Final[dict[str, Any]] = {"cycle": K, "time_ns": K * T_NS}
DECIDED: Final[dict[str, Any]] = {"cycle": K, "time_ns": K * T_NS + 50_000_000}
EFFECTIVE: Final = DECIDED["time_ns"] + 70_000_000
COMMANDED: Final[dict[str, Any]] = {
    **DECIDED,
    "vehicle": 1,
    "effective_ns": EFFECTIVE,
    "acceleration": 0.5,
}


def scenario_of(folder: Path, text: str) -> Scenario:
    (folder / "s.yaml").write_text(text)
    return load(folder / "s.yaml").scenario


def frames(**changes: Any) -> bytes:
    row = {
        "source": [1],
        "destination": [2],
        "sequence": [K],
        "sent_ns": [K * T_NS],
        "arrived_ns": [K * T_NS],
        "latency_ns": [0],
        "distance": [37.5],
        "outcome": [1],
    }
    return pb.Frames(**{**AT, **row, **changes}).SerializeToString()


def beacon_of(source: int = 2, **changes: Any) -> pb.Beacon:
    plan = {"planned_from_ns": [K * T_NS], "planned_acceleration": [0.1]}
    values: dict[str, Any] = {**AT, "vehicle": source, "sequence": K, **plan, **changes}
    return pb.Beacon(**values)


def receive(*beacons: bytes, **changes: Any) -> pb.Receive:
    rows = {"source": [2] * len(beacons), "arrived_ns": [0] * len(beacons), "beacon": beacons}
    return pb.Receive(**{**DECIDED, "vehicle": 1, **rows, **changes})
