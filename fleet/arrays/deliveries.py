"""Beacons in flight: the cycle in which each of them is received, on every link."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from zenvoy.channel.fates import NEVER, Fates
from zenvoy.scenarios import Scenario
from zenvoy.vehicles.arrays.beacons import Beacons, Link
from zenvoy.vehicles.arrays.rows import Bools, Floats, Ints


class Delivery(NamedTuple):
    """The beacons of a cycle that a link delivers.

    to is a mask of the receivers; None means every vehicle that the link reaches.
    """

    link: Link
    cycle: int
    to: Bools | None
    beacons: Beacons


class Deliveries:
    """The channel of runs that differ only in their seed, for some of their links."""

    def __init__(self, scenarios: Sequence[Scenario], links: Sequence[Link]) -> None:
        self._links = links
        self._fates: Fates | None = None
        self._reach = [np.flatnonzero(link.exists) for link in links]
        if links:
            source = np.concatenate(
                [link.sender[to] for link, to in zip(links, self._reach, strict=True)]
            )
            self._fates = Fates(tuple(scenarios), source, np.concatenate(self._reach))
        self._waiting: dict[int, list[tuple[int, list[Bools] | None]]] = defaultdict(list)
        self._beacons: dict[int, Beacons] = {}
        self._still: dict[int, int] = {}  # deliveries to come, by cycle of the beacons

    def send(
        self, cycle: int, beacons: Beacons, speaks: Bools, sequence: Ints, position: Floats
    ) -> None:
        """Put the beacons of a cycle on the air. The arrays cover all vehicles, (runs · n,)."""
        if self._fates is None:
            return
        heard = self._fates.heard(cycle, speaks, sequence, position)
        if isinstance(heard, int):
            self._waiting[heard].append((cycle, None))
            self._still[cycle] = 1
        else:
            cycles = [at for at in np.unique(heard).tolist() if at != NEVER]
            for at in cycles:
                self._waiting[at].append((cycle, self._by_link(heard == at)))
            self._still[cycle] = len(cycles)
        self._beacons[cycle] = beacons

    def due(self, cycle: int) -> Iterator[Delivery]:
        """Yield the deliveries of a cycle, the oldest beacons first."""
        for sent, to in sorted(self._waiting.pop(cycle, []), key=lambda one: one[0]):
            beacons = self._beacons[sent]
            for number, link in enumerate(self._links):
                yield Delivery(link, sent, None if to is None else to[number], beacons)
            self._still[sent] -= 1
        for sent in [sent for sent, left in self._still.items() if left == 0]:
            del self._still[sent], self._beacons[sent]

    def _by_link(self, heard: Bools) -> list[Bools]:
        """Return a mask over all vehicles for each link, from a mask over the frames."""
        masks, at = [], 0
        for link, reach in zip(self._links, self._reach, strict=True):
            mask = np.zeros(len(link.sender), dtype=np.bool_)
            mask[reach] = heard[at : at + len(reach)]
            masks.append(mask)
            at += len(reach)
        return masks
