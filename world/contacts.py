"""Vehicles that run into the vehicle ahead: they are put back, and new collisions are found."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from zenvoy.world.road import Road

Floats = NDArray[np.float64]

# Vehicles that have touched must part by this much before they can collide again.
_APART_M: Final = 0.1


class Contacts:
    """Contacts in one run, or in several runs, each on its own road."""

    def __init__(self, road: Road, length_m: float) -> None:
        self._road, self._length_m = road, length_m
        self._touching: dict[
            int, frozenset[int]
        ] = {}  # indices by run; runs without contact have none
        self.moved = False
        """Whether the newest call put a vehicle back."""

    def found(self, gaps: Floats, position: Floats, speed: Floats) -> list[tuple[int, int]]:
        """Put back vehicles that are too close, and return new collisions: run and index.

        gaps (m), position (m), speed (m/s): (n,), or (runs, n). Changes position and speed in
        place.
        """
        self.moved = False
        close = gaps < self._length_m
        if not self._touching and not np.count_nonzero(close):
            return []
        size = position.shape[-1]
        positions, speeds = position.reshape(-1, size), speed.reshape(-1, size)
        runs = {*self._touching, *np.flatnonzero(close.reshape(-1, size).any(axis=1)).tolist()}
        return [
            (run, index)
            for run in sorted(runs)
            for index in self._in_run(run, positions[run], speeds[run])
        ]

    def _in_run(self, run: int, position: Floats, speed: Floats) -> list[int]:
        new_position, new_speed, moved = self._road.separate(position, speed, self._length_m)
        if moved:
            self.moved = True
            position[:], speed[:] = new_position, new_speed
        before = self._touching.pop(run, frozenset())
        near = self._road.gaps(position) < self._length_m + _APART_M
        touching = (before | set(moved)) & set(np.flatnonzero(near).tolist())
        if touching:
            self._touching[run] = frozenset(touching)
        return [index for index in moved if index not in before]
