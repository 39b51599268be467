"""What the scenario does to vehicles whatever their controllers say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios import Brake

Floats = NDArray[np.float64]


class Braking(NamedTuple):
    """A vehicle (index) brakes at `deceleration` (m/s²) in [from_ns, until_ns)."""

    vehicle: int
    from_ns: int
    until_ns: int
    deceleration: float


class Brakes:
    """All brake events of a scenario."""

    def __init__(self, events: Sequence[Brake]) -> None:
        self.all = [
            Braking(
                event.vehicle - 1,
                round(event.at_s * 1e9),
                round((event.at_s + event.duration_s) * 1e9),
                event.deceleration_mps2,
            )
            for event in events
        ]
        self.instants = sorted({t for b in self.all for t in (b.from_ns, b.until_ns)})

    def override(self, time_ns: int, a: Floats) -> Floats:
        """Accelerations (n,) with those of braking vehicles replaced; the hardest one counts."""
        active = [b for b in self.all if b.from_ns <= time_ns < b.until_ns]
        if not active:
            return a
        a = a.copy()
        for brake in sorted(active, key=lambda b: b.deceleration):
            a[brake.vehicle] = -brake.deceleration
        return a
