"""The data that the parts of the channel share: the frames of a cycle, and the positions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class SentFrames(NamedTuple):
    """The frames of a cycle, a row for each receiver, (r,).

    Source and destination are indices from 0, distance is in m, and sequence is the number of the
    frame.
    """

    source: Ints
    destination: Ints
    distance: Floats
    sequence: Ints

    @property
    def link(self) -> tuple[Ints, Ints, Ints]:
        """The key of the draws for each frame: both ends and the sequence number."""
        return self.source, self.destination, self.sequence

    def only(self, chosen: Bools | slice) -> SentFrames:
        """Return some of the frames."""
        return SentFrames._make(column[chosen] for column in self)


class Scene(NamedTuple):
    """When the frames of a cycle are sent, ns, and the positions of the vehicles (n,), m.

    Positions are along the road, not wrapped. ring_length_m: None on an open road.
    """

    cycle: int
    sent_ns: int
    position: Floats
    ring_length_m: float | None
