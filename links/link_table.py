"""A table with a row of numbers for each link used so far, however few of all links these are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


class LinkTable:
    """Columns of integers, with a row for each ordered pair of `size` vehicles asked for so far.

    `columns` are the initial values of a new row.
    """

    def __init__(self, size: int, *columns: int) -> None:
        self._size = size
        self._initial = columns
        self._code = np.zeros(0, dtype=np.int64)  # in ascending order
        self.columns = [np.zeros(0, dtype=np.int64) for _ in columns]

    def rows(self, source: Ints, destination: Ints) -> Ints:
        """Return the rows of the links (r,), given by indices from 0; valid until the next call."""
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
