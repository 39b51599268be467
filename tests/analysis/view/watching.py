"""Helpers make the log of a run with small chunks, and read what the page gets of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.view.watched import WatchedRun

CYCLES: Final = 60
SCENARIO: Final = """
duration_s: 6
fleet: {size: 5}
control: {v2v_wait_ms: 50, system_delay_ms: 70}
channel: {technology: lte-a-pro, loss: {p: 0.2}}
events: [{type: brake, vehicle: 2, at_s: 1, duration_s: 1, deceleration_mps2: 2}]
"""


def unpack(block: bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays of a block, as the page reads them."""
    length = int.from_bytes(block[:4], "little")
    found, at = {}, 4 + length
    for name, dtype, shape in json.loads(block[4:at])["arrays"]:
        assert at % 8 == 0
        count = int(np.prod(shape))
        found[name] = np.frombuffer(block, dtype, count, at).reshape(shape)
        at += -(-count * np.dtype(dtype).itemsize // 8) * 8
    assert at == len(block)
    return found


def watched(path: Path) -> WatchedRun:
    """Return a run of which everything that the log has is read."""
    made = WatchedRun(path)
    while made.extend():
        pass
    return made
