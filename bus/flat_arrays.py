"""Encodes and decodes many messages of one form at once, each field as an array.

Messages of numbers of fixed width, in the same fields, have the same length and the same tags
(`flat`). So together they are a table, whose columns numpy fills or reads in one call each.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from zenvoy.bus.flat import Piece

DTYPES: Final = {
    "d": "<f8",
    "q": "<i8",
    "Q": "<u8",
    "f": "<f4",
    "i": "<i4",
    "I": "<u4",
    "B": "u1",
}


class FlatTable:
    """Messages that consist of these pieces."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        template, offsets, formats = bytearray(), [], []
        fixed = []
        for piece in pieces:
            fixed.append(np.arange(len(template), len(template) + len(piece.head)))
            template += piece.head
            offsets.append(len(template))
            formats.append((DTYPES[piece.code], (piece.many,) if piece.many else ()))
            width = np.dtype(formats[-1]).itemsize
            template += bytes(width)
        self.size = len(template)
        """The length of a message, bytes."""
        self.varints = tuple(piece.name for piece in pieces if piece.code == "B")
        """The enums and booleans. Any byte is read there; one above 127 is only part of a value."""
        self._template = bytes(template)
        self._fixed = np.concatenate(fixed)
        self._dtype = np.dtype(
            {
                "names": [piece.name for piece in pieces],
                "formats": formats,
                "offsets": offsets,
                "itemsize": self.size,
            }
        )

    def encode(self, count: int, **columns: ArrayLike) -> list[bytes]:
        """Return `count` messages; a column has a number for each of them, or one for all.

        Raises KeyError if a field is missing.
        """
        table = np.frombuffer(bytearray(self._template * count), self._dtype)
        for name in self._dtype.names or ():
            table[name] = columns[name]
        data, size = table.tobytes(), self.size
        return [data[at : at + size] for at in range(0, count * size, size)]

    def decode(self, payloads: Sequence[bytes]) -> NDArray[Any] | None:
        """Return the messages as a structured array; None if any of them has another form."""
        if any(len(payload) != self.size for payload in payloads):
            return None
        data = b"".join(payloads)
        return self.rows(data) if self.fits(data).all() else None

    def fits(self, data: bytes) -> NDArray[np.bool_]:
        """Return which of the messages in a row, all of this length, have this form."""
        rows = np.frombuffer(data, np.uint8).reshape(-1, self.size)
        template = np.frombuffer(self._template, np.uint8)
        found: NDArray[np.bool_] = (rows[:, self._fixed] == template[self._fixed]).all(axis=1)
        return found

    def rows(self, data: bytes) -> NDArray[Any]:
        """Return messages of this form in a row as a structured array."""
        return np.frombuffer(data, self._dtype)
