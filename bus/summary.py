"""Sums up the fleet at a cycle in single numbers, which plots show best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec

_FRAMES = PackedCodec(pb.Frames.DESCRIPTOR)


class Summary:
    """Makes summaries of the fleet. The newest frames count for the truth that follows them."""

    def __init__(self, ring_length_m: float | None) -> None:
        self._ring_length_m = ring_length_m
        self._outcomes = np.zeros(len(pb.Outcome.values()), np.int64)

    def take(self, frames: bytes) -> None:
        """Take a serialized Frames; raises ValueError for anything else."""
        outcome = _FRAMES.decode(frames)["outcome"]
        known = outcome[outcome < len(self._outcomes)]
        self._outcomes = np.bincount(known, minlength=len(self._outcomes))

    def of(self, truth: pb.FleetTruth) -> pb.FleetSummary:
        """Return the summary of a cycle."""
        gaps = self._gaps(np.array(truth.position))
        count = self._outcomes
        return pb.FleetSummary(
            cycle=truth.cycle,
            time_ns=truth.time_ns,
            mean_speed=float(np.mean(truth.speed)),
            speed_rms=_rms_from_mean(truth.speed),
            smallest_gap=float(gaps.min()),
            gap_rms=_rms_from_mean(gaps),
            delivered=count[pb.OUTCOME_DELIVERED],
            late=count[pb.OUTCOME_LATE],
            lost=count[pb.OUTCOME_LOST] + count[pb.OUTCOME_CORRUPTED],
            collided=count[pb.OUTCOME_COLLIDED],
        )

    def _gaps(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gaps from front to front, m: of all vehicles of a ring, else of all but 1."""
        gaps = position[:-1] - position[1:]
        if self._ring_length_m is None:
            return gaps
        return np.append(position[-1] + self._ring_length_m - position[0], gaps)


def _rms_from_mean(values: Sequence[float] | NDArray[np.float64]) -> float:
    return float(np.std(np.asarray(values, np.float64)))
