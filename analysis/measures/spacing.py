"""From where to where a report gives gaps: between fronts, or between bumpers.

Logs and measures have gaps from front to front. A scenario that gives its own gaps from bumper to
bumper is reported so; `fleet.reported_gaps` says it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Scenario

Gap = TypeVar("Gap", float, NDArray[np.float64])

_FRONT: Final = "front to front"
_BUMPER: Final = "bumper to bumper"


@dataclass(frozen=True, slots=True, kw_only=True)
class Spacing:
    """How gaps are shown: less by a length (m), and named by words, "" for the usual ones."""

    less_m: float = 0.0
    words: str = ""

    @property
    def of_gaps(self) -> str:
        """How gaps are measured, in words."""
        return self.words or _FRONT

    def shown(self, gap: Gap) -> Gap:
        """Return gaps from front to front, m, as they are shown."""
        return gap - self.less_m if self.less_m else gap

    def named(self, text: str, unit: str = "") -> str:
        """Return the name of a gap that says how it is measured, and its unit."""
        return ", ".join(part for part in (text, self.words, unit) if part)


FRONTS: Final = Spacing()


def spacing_of(scenario: Scenario) -> Spacing:
    """Return how the gaps of a scenario are shown."""
    if scenario.fleet.reported_gaps == "front-to-front":
        return FRONTS
    return Spacing(less_m=scenario.fleet.length_m, words=_BUMPER)


def together(scenarios: Sequence[Scenario]) -> list[Spacing]:
    """Return how gaps are shown side by side: as those of all scenarios, or else between fronts."""
    found = [spacing_of(scenario) for scenario in scenarios]
    if len({spacing.words for spacing in found}) == 1:
        return found
    return [Spacing(words=_FRONT) for _ in scenarios]
