"""What becomes of the frames of a cycle: range, loss, latency, outcome. Pure functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.draws import Purpose, uniforms
from zenvoy.channel.pairs import Pairs
from zenvoy.channel.technologies import Technology

Ints = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Medium:
    """A technology with its settings: loss probability, frame time and delay bounds in ns."""

    technology: Technology
    seed: int
    loss: float
    frame_bytes: int
    bit_rate_mbps: float | None

    @property
    def frame_time_ns(self) -> int:
        """Time on the air: frame bits over bit rate."""
        rate_mbps = self.bit_rate_mbps or self.technology.default_mbps
        return round(8_000 * self.frame_bytes / rate_mbps)


class Fate(NamedTuple):
    """A row per frame and receiver, parallel to the pairs. Times in ns; -1: never arrives."""

    latency_ns: Ints
    arrived_ns: Ints
    outcome: NDArray[np.uint32]


def fates(
    pairs: Pairs,
    sequence: NDArray[np.int64],
    sent_ns: int,
    deadline_ns: int,
    medium: Medium,
    lost_before: NDArray[np.bool_] | None = None,
) -> Fate:
    """Outcome of one frame per source, sent at `sent_ns`; `sequence` (n,) by source.

    `lost_before`: frames that are lost in any case, parallel to the pairs.
    A frame that arrives by `deadline_ns` comes with the first delivery after it was sent. Draws
    are keyed by seed, source, destination and sequence number.
    """
    lost, delay_ns = _draw(pairs, sequence, medium)
    if lost_before is not None:
        lost |= lost_before
    latency_ns = delay_ns + medium.frame_time_ns * _turn(pairs, medium.technology.broadcast)
    arrived_ns = sent_ns + latency_ns
    outcome = np.where(arrived_ns <= deadline_ns, pb.OUTCOME_DELIVERED, pb.OUTCOME_LATE)
    outcome[lost] = pb.OUTCOME_LOST
    outcome[~pairs.in_range] = pb.OUTCOME_OUT_OF_RANGE
    gone = (outcome == pb.OUTCOME_LOST) | (outcome == pb.OUTCOME_OUT_OF_RANGE)
    latency_ns[gone] = arrived_ns[gone] = -1
    return Fate(latency_ns, arrived_ns, outcome.astype(np.uint32))


def _draw(
    pairs: Pairs, sequence: NDArray[np.int64], medium: Medium
) -> tuple[NDArray[np.bool_], Ints]:
    """Which frames are lost, and the delay of each (ns), where it is not."""
    rows = len(pairs.source)
    low_ns, high_ns = (round(bound * 1e6) for bound in medium.technology.delay_ms)
    if medium.loss == 0.0 and low_ns == high_ns:  # nothing to draw
        return np.zeros(rows, dtype=np.bool_), np.full(rows, low_ns)
    loss, share = uniforms(
        medium.seed,
        Purpose.LOSS_AND_LATENCY,
        pairs.source + 1,
        pairs.destination + 1,
        sequence[pairs.source],
    )
    return loss < medium.loss, low_ns + np.floor(share * (high_ns - low_ns)).astype(np.int64)


def _turn(pairs: Pairs, broadcast: bool) -> Ints:
    """Which copy of its sender's a frame is, from 1; with broadcast there is only one.

    Copies go out to the nearest receiver first.
    """
    turn = np.ones(len(pairs.source), dtype=np.int64)
    if broadcast:
        return turn
    order = np.lexsort((pairs.destination, pairs.distance, ~pairs.in_range, pairs.source))
    sources = pairs.source[order]
    first = np.searchsorted(sources, sources, side="left")
    turn[order] = np.arange(len(order)) - first + 1
    return turn
