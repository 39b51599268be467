"""Samples a whole run for the space-time diagram and the load of the channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.view.picture import TOTALS, Picture

POINTS = 1_500
"""At most this many cycles of a run are sampled, and about as many vehicles."""


class Overview:
    """Position and speed of vehicles, and the totals, in every n-th cycle of a run."""

    def __init__(self, cycles: int, vehicles: int) -> None:
        self.stride = max(1, -(-cycles // POINTS))
        """One cycle in so many is sampled."""
        self.vehicles = np.arange(0, vehicles, max(1, -(-vehicles // POINTS)))
        """Indices of the vehicles sampled."""
        self._position: list[NDArray[np.float64]] = []
        self._speed: list[NDArray[np.float32]] = []
        self._totals: list[NDArray[np.float32]] = []

    def __len__(self) -> int:
        return len(self._totals)

    @property
    def due(self) -> int:
        """The cycle to be added next."""
        return len(self) * self.stride

    def add(self, picture: Picture | None) -> None:
        """Add the cycle that is due; None where the log does not have it."""
        if picture is None:
            nothing = np.full(len(self.vehicles), np.nan)
            self._position.append(nothing)
            self._speed.append(nothing.astype(np.float32))
            self._totals.append(np.full(len(TOTALS), np.nan, np.float32))
            return
        self._position.append(picture.position[self.vehicles])
        self._speed.append(picture.columns[0, self.vehicles])
        self._totals.append(picture.totals)

    def since(self, first: int) -> dict[str, NDArray[np.generic]]:
        """Return the points from number `first` on: positions, speeds, totals and vehicles."""
        size = len(self.vehicles)
        return {
            "cycle": np.arange(first, len(self), dtype=np.uint32) * np.uint32(self.stride),
            "vehicle": (self.vehicles + 1).astype(np.uint32),
            "position": np.array(self._position[first:], np.float64).reshape(-1, size),
            "speed": np.array(self._speed[first:], np.float32).reshape(-1, size),
            "totals": np.array(self._totals[first:], np.float32).reshape(-1, len(TOTALS)),
        }
