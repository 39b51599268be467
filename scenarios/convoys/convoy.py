"""A platoon of cars as recorded, and the raw table that it is cut from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Table:
    """The motion of cars in a file, front to back; NaN where the file has no value.

    numbers has the place of each car in the file, from 1 on: only cars of successive numbers follow
    each other. time_s (T,) increases. speed, position and gap are (T, n), in m/s and m, or None
    where the file has no such columns. A gap is from bumper to bumper, to the car ahead.
    gap_columns has the name of each column of gaps, and gap_lines (T, n) the lines of their values.
    setting says how the cars were driven, "" if the file does not say.
    """

    cars: tuple[str, ...]
    numbers: tuple[int, ...]
    time_s: Floats
    speed: Floats | None = None
    position: Floats | None = None
    gap: Floats | None = None
    gap_columns: tuple[str, ...] = ()
    gap_lines: NDArray[np.int64] | None = None
    setting: str = ""

    def of_cars(self, which: Sequence[int]) -> Table:
        """Return the table with only these cars, by index and in this order."""
        some = list(which)
        return replace(
            self,
            cars=tuple(self.cars[car] for car in some),
            numbers=tuple(self.numbers[car] for car in some),
            speed=None if self.speed is None else self.speed[:, some],
            position=None if self.position is None else self.position[:, some],
            gap=None if self.gap is None else self.gap[:, some],
            gap_columns=tuple(self.gap_columns[car] for car in some),
            gap_lines=None if self.gap_lines is None else self.gap_lines[:, some],
        )

    def of_rows(self, which: NDArray[np.bool_]) -> Table:
        """Return the table with only these rows (T,)."""
        return replace(
            self,
            time_s=self.time_s[which],
            speed=None if self.speed is None else self.speed[which],
            position=None if self.position is None else self.position[which],
            gap=None if self.gap is None else self.gap[which],
            gap_lines=None if self.gap_lines is None else self.gap_lines[which],
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Convoy:
    """A platoon of cars as recorded, on an even clock and without holes.

    cars has their names, the leader first. time_s (T,) begins at 0. speed (T, n) is in m/s, gap
    (T, n) in m from bumper to bumper, NaN for the leader. told says how it was read: names of
    figures, and their values.
    """

    name: str
    cars: tuple[str, ...]
    time_s: Floats
    speed: Floats
    gap: Floats
    setting: str = ""
    told: dict[str, str] = field(default_factory=dict)

    @property
    def period_s(self) -> float:
        """Time between two rows, s."""
        return float(self.time_s[1] - self.time_s[0])
