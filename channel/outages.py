"""Outages: times, links and stretches of road where nothing gets through."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.channel.where import Where
from zenvoy.scenarios import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Outages:
    """The outages of a scenario, or of several that differ only in their seed."""

    def __init__(self, *scenarios: Scenario) -> None:
        outages = scenarios[0].channel.outages
        self._places = [Where(outage, *scenarios) for outage in outages]

    def lost(self, source: Ints, destination: Ints, position: Floats, sent_ns: int) -> Bools | None:
        """Return which frames an outage blocks, (r,); None if no outage is current.

        The arguments are those of `Where.covers`.
        """
        found = (place.covers(source, destination, position, sent_ns) for place in self._places)
        current = [covered for covered in found if covered is not None]
        return np.logical_or.reduce(current) if current else None
