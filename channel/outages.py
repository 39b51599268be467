"""Outages: times, links and stretches of road where nothing gets through."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Outage, Scenario, group_members, members

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class _Spell(NamedTuple):
    """An outage, worked out: times in ns, and who sends to whom, (n,) by index from 0."""

    from_ns: int
    until_ns: float
    sends: Bools
    hears: Bools
    from_m: float
    to_m: float


class Outages:
    """The outages of a scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self._ring_length_m = scenario.ring_length_m
        groups = group_members(scenario)
        size = scenario.fleet.size

        def mask(text: str | None) -> Bools:
            named = members(text or "all", size, groups)
            return np.array([vehicle in named for vehicle in range(1, size + 1)])

        self._spells = [
            _spell(outage, mask(outage.source), mask(outage.destination))
            for outage in scenario.channel.outages
        ]

    def lost(self, source: Ints, destination: Ints, position: Floats, sent_ns: int) -> Bools | None:
        """Which frames an outage takes; None where there is none at `sent_ns`.

        source, destination: (r,), indices from 0; position: (n,), m along the road, not wrapped.
        """
        current = [spell for spell in self._spells if spell.from_ns <= sent_ns < spell.until_ns]
        if not current:
            return None
        lost = np.zeros(len(source), dtype=np.bool_)
        for spell in current:
            inside = self._inside(position, spell)
            there = inside[source] | inside[destination]
            lost |= spell.sends[source] & spell.hears[destination] & there
        return lost

    def _inside(self, position: Floats, spell: _Spell) -> Bools:
        """Who is on the stretch, (n,)."""
        place = position
        if self._ring_length_m is not None:
            place = np.mod(position, self._ring_length_m)
        after, before = place >= spell.from_m, place <= spell.to_m
        return after & before if spell.from_m <= spell.to_m else after | before


def _spell(outage: Outage, sends: Bools, hears: Bools) -> _Spell:
    return _Spell(
        from_ns=round(outage.from_s * 1e9),
        until_ns=math.inf if outage.until_s is None else round(outage.until_s * 1e9),
        sends=sends,
        hears=hears,
        from_m=-math.inf if outage.from_m is None else outage.from_m,
        to_m=math.inf if outage.to_m is None else outage.to_m,
    )
