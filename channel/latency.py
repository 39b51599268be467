"""Latency of frames under one section of a scenario."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.sender_offset import SenderOffsets
from zenvoy.keyed_random.draws import Seeds
from zenvoy.links.distribution import greatest_ns
from zenvoy.links.sent_frames import SentFrames
from zenvoy.links.table import distributions
from zenvoy.scenarios import Latency

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class Latencies:
    """The latencies of one section; sections with different `number` have independent draws.

    technology_ms: the bounds of the technology's delay in Table I.
    """

    def __init__(
        self,
        latency: Latency,
        technology_ms: tuple[float, float],
        seeds: Seeds,
        number: int = 0,
    ) -> None:
        distribution = distributions()[latency.distribution]
        self._delays = distribution.quantile(latency, technology_ms)
        self._offsets = SenderOffsets(latency.sender_offset, seeds, number)
        self.least_ns = int(self._delays(np.zeros(1))[0])  # quantile functions never fall
        self.greatest_ns = None if self._offsets.used else greatest_ns(self._delays)
        self.ordered = not latency.reorder
        self.draws = not distribution.constant(technology_ms)

    def of(self, frames: SentFrames, share: Floats) -> Ints:
        """Return latencies, ns, (r,); share: a draw in [0, 1) for each frame."""
        return self._delays(share) + self._offsets.of(frames)
