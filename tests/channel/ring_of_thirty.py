"""Helpers give the scenario and the links of 30 vehicles on a ring, all in range of each other."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.packed import PackedCodec
from zenvoy.scenarios import Channel, Control, Fleet, Scenario

Ints = NDArray[np.int64]

SIZE: Final = 30
MS_NS: Final = 1_000_000
S_NS: Final = 1_000_000_000
GAP_M: Final = 20.0
POSITION: Final = np.arange(SIZE - 1, -1, -1.0) * GAP_M  # on a ring of 600 m, vehicle 1 ahead
SOURCE, DESTINATION = (
    index[~np.eye(SIZE, dtype=bool)] for index in np.indices((SIZE, SIZE), dtype=np.int64)
)
AROUND: Final = np.mod(POSITION[SOURCE] - POSITION[DESTINATION], 600.0)
DISTANCE: Final = np.minimum(AROUND, 600.0 - AROUND)
FRAMES: Final = PackedCodec(pb.Frames.DESCRIPTOR)


def scenario(channel: Channel, cycles: int = 40) -> Scenario:
    """Return a scenario of 30 vehicles with a channel."""
    return Scenario(
        duration_s=cycles * 0.1,
        fleet=Fleet(size=SIZE, gap_m=GAP_M),
        control=Control(v2v_wait_ms=20.0),
        channel=channel,
    )


def within(share: float, p: float, n: int) -> bool:
    """Return whether a share of n lies in the 99 % interval about p."""
    return bool(abs(share - p) <= 2.58 * np.sqrt(p * (1.0 - p) / n))
