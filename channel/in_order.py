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
        """Return the arrivals, ns: ordered frames do not arrive before earlier frames of the link.

        All arrays are (r,), one row per link. A frame that never arrives (-1) delays no other.
        """
        rows = self._table.rows(source, destination)
        newest = self._table.columns[0]
        waits = ordered & (arrived_ns >= 0)
        held = np.where(waits, np.maximum(arrived_ns, newest[rows]), arrived_ns)
        newest[rows] = np.maximum(newest[rows], held)
        return held
