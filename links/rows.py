"""What the parts of the channel hand each other: the frames of a cycle, and where everyone is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Rows(NamedTuple):
    """Frames by receiver, (r,): indices from 0 of both ends, distance in m, sequence numbers."""

    source: Ints
    destination: Ints
    distance: Floats
    sequence: Ints

    @property
    def link(self) -> tuple[Ints, Ints, Ints]:
        """What keys their draws: both ends, and the number of the frame."""
        return self.source, self.destination, self.sequence

    def only(self, chosen: Bools | slice) -> Rows:
        """Those of the rows."""
        return Rows._make(column[chosen] for column in self)


class Scene(NamedTuple):
    """The instant at which the frames of a cycle are sent, ns, and the vehicles' positions (n,), m.

    Positions are along the road, not wrapped; ring_length_m: None on the open road.
    """

    cycle: int
    sent_ns: int
    position: Floats
    ring_length_m: float | None
