"""Ring and open road: gaps between vehicles, and contact between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from zenvoy.links.distance import gaps

Floats = NDArray[np.float64]

# A tolerance, so that rounding does not make vehicles that touch overlap.
_TOUCH_M = 1e-9


@dataclass(frozen=True, slots=True)
class Road:
    """A road with one lane, open if `ring_length_m` is None. Vehicle i follows vehicle i - 1."""

    ring_length_m: float | None

    def gaps(self, position: Floats) -> Floats:
        """Return the gaps p_(i,i-1), m, (…, n); NaN for the first vehicle of an open road.

        position: m along the road, not wrapped.
        """
        return gaps(position, self.ring_length_m)

    def separate(
        self, position: Floats, speed: Floats, length_m: float
    ) -> tuple[Floats, Floats, list[int]]:
        """Put each follower that is too close at the bumper of its leader, at the leader's speed.

        Returns positions, speeds and the indices of the followers that were put back.
        """
        gap = self.gaps(position)
        if not (gap < length_m - _TOUCH_M).any():
            return position, speed, []
        position, speed = position.copy(), speed.copy()
        n = len(position)
        # Start at a vehicle with room ahead. A vehicle put back may push the next one, so go on
        # around the ring.
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
