"""Ring and open road: gaps between vehicles, and what happens when one is too short."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]

# Vehicles that touch stay in touch through rounding.
_TOUCH_M = 1e-9


@dataclass(frozen=True, slots=True)
class Road:
    """A road without lanes; `ring_length_m` None: open. Vehicle i follows i - 1."""

    ring_length_m: float | None

    def gaps(self, position: Floats) -> Floats:
        """p_(i,i-1) (…, n), m. Positions are not wrapped; NaN for the first of the open road."""
        return gaps(position, self.ring_length_m)

    def separate(
        self, position: Floats, speed: Floats, length_m: float
    ) -> tuple[Floats, Floats, list[int]]:
        """Put each follower that is too close at the bumper of its leader, with its speed.

        Returns position, speed and the indices of the followers that were put back.
        """
        gap = self.gaps(position)
        if not (gap < length_m - _TOUCH_M).any():
            return position, speed, []
        position, speed = position.copy(), speed.copy()
        n = len(position)
        # From a vehicle with room ahead; a vehicle put back may push the next one, so go round.
        start = 0 if self.ring_length_m is None else int(np.argmax(gap))
        moved: list[int] = []
        for step in range(1, 2 * n if self.ring_length_m is not None else n):
            i = (start + step) % n
            leader = position[i - 1] + (self.ring_length_m or 0.0 if i == 0 else 0.0)
            if leader - position[i] < length_m - _TOUCH_M:
                position[i], speed[i] = leader - length_m, speed[i - 1]
                if i not in moved:
                    moved.append(i)
        return position, speed, moved
