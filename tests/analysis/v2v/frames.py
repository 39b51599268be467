"""Helpers give frames: a scenario that sends some, and columns of /v2v/frames without a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st

from zenvoy.analysis.log.columns import Table
from zenvoy.bus import messages_pb2 as pb

LTE = """
duration_s: 40
seed: 3
fleet: {size: 8}
control: {model: BCM, v2v_wait_ms: 30, system_delay_ms: 100}
channel: {technology: lte-a-pro, loss: {p: 0.3}}
"""
PERIOD_NS, WAIT_NS = 100, 30
DELIVERED, LATE, LOST, OUT = (
    pb.OUTCOME_DELIVERED,
    pb.OUTCOME_LATE,
    pb.OUTCOME_LOST,
    pb.OUTCOME_OUT_OF_RANGE,
)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    """Draw columns of /v2v/frames: 3 vehicles, some cycles, any outcome of each frame."""
    rows: list[tuple[int, ...]] = []
    for cycle in range(draw(st.integers(1, 8))):
        for source in (1, 2, 3):
            for destination in {1, 2, 3} - {source}:
                latency = draw(st.sampled_from([-2, -1, 0, 29, 30, 31, 99, 130, 131, 350]))
                rows.append((cycle, source, destination, latency))
    cycle, source, destination, latency = np.array(rows, dtype=np.int64).T
    known_in = -((WAIT_NS - latency) // PERIOD_NS)
    outcome = np.where(known_in == 0, DELIVERED, LATE)
    outcome = np.where(latency == -1, LOST, np.where(latency == -2, OUT, outcome))
    sent = cycle * PERIOD_NS
    return {
        "cycle": cycle.astype(np.uint32),
        "source": source.astype(np.uint16),
        "destination": destination.astype(np.uint16),
        "sequence": cycle.astype(np.uint32),
        "sent_ns": sent,
        "arrived_ns": np.where(latency >= 0, sent + latency, -1),
        "latency_ns": np.maximum(latency, -1),
        "distance": (37.5 * np.abs(source - destination)).astype(np.float32),
        "outcome": outcome.astype(np.uint8),
    }


def table_of(outcomes: Sequence[int], **columns: Any) -> Table:
    """Return frames of one link with these outcomes in order, and other columns as given."""
    number = len(outcomes)
    table: Table = {
        "cycle": np.arange(number, dtype=np.uint32),
        "source": np.full(number, 1, np.uint16),
        "destination": np.full(number, 2, np.uint16),
        "sequence": np.arange(number, dtype=np.uint32),
        "outcome": np.array(outcomes, np.uint8),
    }
    return {**table, **{name: np.asarray(values) for name, values in columns.items()}}
