"""Links on which no frame overtakes another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.link_table import LinkTable

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class InOrder:
    """Holds a frame back until the one before it on its link has arrived."""

    def __init__(self, size: int) -> None:
        self._table = LinkTable(size, 0)  # arrival of the newest frame, ns

    def held(self, source: Ints, destination: Ints, arrived_ns: Ints, ordered: Bools) -> Ints:
        """Arrivals, ns; where `ordered`, not before that of an earlier frame of the link.

        All (r,), a row per link; -1: never arrives, and holds nobody up.
        """
        rows = self._table.rows(source, destination)
        newest = self._table.columns[0]
        waits = ordered & (arrived_ns >= 0)
        held = np.where(waits, np.maximum(arrived_ns, newest[rows]), arrived_ns)
        newest[rows] = np.maximum(newest[rows], held)
        return held
