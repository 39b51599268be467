"""Decentralised congestion control: stations send less often where the medium is busy."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# ETSI TS 102 687 V1.2.1, Table A.1: upper bounds of the busy ratio of each state but the last, and
# the least time between two frames in each state.
_RATIOS: Final = np.array([0.30, 0.40, 0.50, 0.60])
_OFF_NS: Final = np.array([100, 200, 400, 500, 1_000]) * 1_000_000


class ReactiveDcc:
    """The reactive approach: the last busy ratio selects relaxed, active 1 to 3, or restrictive."""

    def __init__(self, size: int) -> None:
        self._off_ns = np.full(size, _OFF_NS[0])
        self._next_ns = np.zeros(size, dtype=np.int64)

    def allowed(self, speaks: Bools, now_ns: int) -> Bools:
        """Return which of the stations with a frame send it now, (n,)."""
        sends = speaks & (now_ns >= self._next_ns)
        self._next_ns[sends] = now_ns + self._off_ns[sends]
        return np.asarray(sends)

    def sensed(self, busy_ratio: Floats) -> None:
        """Take in the busy ratio of a period, (n,)."""
        self._next_ns -= self._off_ns
        self._off_ns = _OFF_NS[np.searchsorted(_RATIOS, busy_ratio, side="right")]
        self._next_ns += self._off_ns
