"""A row of numbers for each link that has been seen, however few of all links these are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


class LinkTable:
    """Columns of integers, a row per ordered pair of `size` vehicles that was ever asked for.

    `columns`: what each of them holds in a new row.
    """

    def __init__(self, size: int, *columns: int) -> None:
        self._size = size
        self._initial = columns
        self._code = np.zeros(0, dtype=np.int64)  # in rising order
        self.columns = [np.zeros(0, dtype=np.int64) for _ in columns]

    def rows(self, source: Ints, destination: Ints) -> Ints:
        """Where the links (r,), indices from 0, have their rows; valid until the next call."""
        code = source * self._size + destination
        rows = np.searchsorted(self._code, code)
        known = rows < len(self._code)
        known[known] = self._code[rows[known]] == code[known]
        if not known.all():
            new = np.unique(code[~known])
            places = np.searchsorted(self._code, new)
            self._code = np.insert(self._code, places, new)
            for index, initial in enumerate(self._initial):
                self.columns[index] = np.insert(self.columns[index], places, initial)
            rows = np.searchsorted(self._code, code)
        return rows.astype(np.int64)
