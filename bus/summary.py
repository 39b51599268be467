"""Sums up the fleet at a cycle in single numbers, which plots show best."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec

GapsOf = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Returns gaps from front to front for positions, both m and (n,); NaN where nobody is ahead."""

_FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


class Summary:
    """Makes summaries of the fleet. The newest frames count for the truth that follows them."""

    def __init__(self, gaps_of: GapsOf) -> None:
        self._gaps_of = gaps_of
        self._outcomes = np.zeros(len(pb.Outcome.values()), np.int64)

    def take(self, frames: bytes) -> None:
        """Take a serialized Frames; raises ValueError for anything else."""
        outcome = _FRAMES.decode(frames)["outcome"]
        known = outcome[outcome < len(self._outcomes)]
        self._outcomes = np.bincount(known, minlength=len(self._outcomes))

    def of(self, truth: pb.FleetTruth) -> pb.FleetSummary:
        """Return the summary of a cycle."""
        gaps = self._gaps_of(np.array(truth.position))
        count = self._outcomes
        return pb.FleetSummary(
            cycle=truth.cycle,
            time_ns=truth.time_ns,
            mean_speed=float(np.mean(truth.speed)),
            speed_rms=float(np.std(truth.speed)),
            smallest_gap=float(np.nanmin(gaps)),
            gap_rms=float(np.nanstd(gaps)),
            delivered=count[pb.OUTCOME_DELIVERED],
            late=count[pb.OUTCOME_LATE],
            lost=count[pb.OUTCOME_LOST] + count[pb.OUTCOME_CORRUPTED],
            collided=count[pb.OUTCOME_COLLIDED],
        )
