"""Where and when a rule or an outage applies: times, links and stretches of road."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Scenario, Scope, group_members, members

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Where:
    """A scope of a scenario, resolved: times in ns, and masks of senders and receivers."""

    def __init__(self, scope: Scope, *scenarios: Scenario) -> None:
        """Take the scenarios of runs side by side, which differ only in their seed."""
        size = scenarios[0].fleet.size
        groups = [group_members(scenario) for scenario in scenarios]  # some are drawn by seed

        def mask(text: str | None) -> Bools:
            named = [members(text or "all", size, of_run) for of_run in groups]
            return np.array([v in of_run for of_run in named for v in range(1, size + 1)])

        self._ring_length_m = scenarios[0].ring_length_m
        self._from_ns = round(scope.from_s * 1e9)
        self._until_ns = math.inf if scope.until_s is None else round(scope.until_s * 1e9)
        self._sends, self._hears = mask(scope.source), mask(scope.destination)
        self._from_m = -math.inf if scope.from_m is None else scope.from_m
        self._to_m = math.inf if scope.to_m is None else scope.to_m

    def covers(
        self, source: Ints, destination: Ints, position: Floats, sent_ns: int
    ) -> Bools | None:
        """Return to which frames, sent at `sent_ns`, the scope applies, (r,); None if to none.

        source, destination: (r,), indices from 0. position: (n,), m along the road, not wrapped. It
        is enough that sender or receiver is on the stretch.
        """
        if not self._from_ns <= sent_ns < self._until_ns:
            return None
        inside = self._inside(position)
        there = inside[source] | inside[destination]
        return self._sends[source] & self._hears[destination] & there

    def _inside(self, position: Floats) -> Bools:
        """Return which vehicles are on the stretch, (n,)."""
        place = position
        if self._ring_length_m is not None:
            place = np.mod(position, self._ring_length_m)
        after, before = place >= self._from_m, place <= self._to_m
        return after & before if self._from_m <= self._to_m else after | before
