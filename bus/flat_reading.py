"""Reads many flat messages of a type at once, whatever forms they have, as columns of numpy.

`flat_arrays` needs to know the form of a message. Here it is found: the tags of a message say which
fields it has, and how many numbers are in its columns.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from numpy.typing import NDArray

from zenvoy.bus.flat import CODES, Piece
from zenvoy.bus.flat_arrays import FlatTable
from zenvoy.bus.packed import read_varint

# Any program that may write to a key can invent forms.
_MOST_FORMS: Final = 200  # that are kept; a fleet has dozens
_MOST_OF_A_SIZE: Final = 20  # of the messages that are read together
_LARGEST: Final = 16_384  # bytes; a vehicle that reports 700 frames sends less

_WIDTHS: Final = {0: 1, 1: 8, 5: 4}  # bytes by wire type; a varint has one
_LENGTH_DELIMITED: Final = 2
_LARGEST_VARINT: Final = 0x7F  # of one byte
_CODES: Final = CODES | {FieldDescriptor.TYPE_BOOL: ("B", 0)}


class Alike(NamedTuple):
    """Messages of one form: their places among all, (k,), and their fields, a structured (k,)."""

    at: NDArray[np.intp]
    fields: NDArray[Any]


class FlatReader:
    """Reads messages of numbers of fixed width, booleans, enums below 128, columns and messages.

    It reads only what protobuf reads, and leaves the rest to protobuf: unknown fields, fields that
    come twice, larger enums, messages above 16 kB, and messages without numbers.
    """

    def __init__(self, descriptor: Descriptor) -> None:
        self._descriptor = descriptor
        self._tables: dict[int, FlatTable] = {}  # by size: the form of the last such message

    def read(self, payloads: Sequence[bytes]) -> list[Alike] | None:
        """Return the messages, grouped by form; None if any is of no such form.

        The name of a field in a nested message has both names: `gap` of `ahead` is `ahead_gap`.
        Fields that a message leaves out are missing from its group.
        """
        by_size = defaultdict[int, list[int]](list)
        for at, payload in enumerate(payloads):
            by_size[len(payload)].append(at)
        found = []
        for size, rows in by_size.items():
            left = np.array(rows)
            for _ in range(_MOST_OF_A_SIZE):
                data = b"".join([payloads[at] for at in left.tolist()])
                table = self._table(data[:size]) if size <= _LARGEST else None
                if table is None:
                    return None
                fits = table.fits(data)
                fields = table.rows(data)[fits]
                if any((fields[name] > _LARGEST_VARINT).any() for name in table.varints):
                    return None
                found.append(Alike(left[fits], fields))
                left = left[~fits]
                if not len(left):
                    break
            else:
                return None
        return found

    def _table(self, payload: bytes) -> FlatTable | None:
        """Return the form of a message, or None if it has none."""
        table = self._tables.get(len(payload))
        if table is not None and table.fits(payload).all():
            return table
        pieces = _form_of(self._descriptor, payload)
        if pieces is None:
            return None
        if len(self._tables) >= _MOST_FORMS:
            self._tables.clear()
        table = self._tables[len(payload)] = FlatTable(pieces)
        return table


def _form_of(descriptor: Descriptor, payload: bytes) -> list[Piece] | None:
    """Return the parts of a message, in order; None if it is not flat, or not whole."""
    pieces: dict[str, Piece] = {}
    try:
        for piece in _pieces(descriptor, payload):
            if piece.name in pieces:
                return None
            pieces[piece.name] = piece
    except ValueError:
        return None
    return list(pieces.values()) or None


def _pieces(descriptor: Descriptor, payload: bytes) -> Iterator[Piece]:
    """Yield the parts of a message; raises ValueError if it is not flat, or not whole.

    The head of a part reaches back to the end of the one before. So that of the first number in a
    nested message begins with the tag and the length of that message.
    """
    start = at = 0
    within: list[tuple[Descriptor, str, int]] = [(descriptor, "", len(payload))]
    while True:
        of, prefix, end = within[-1]
        if at == end:
            within.pop()
            if not within:
                break
            continue
        key, at = read_varint(payload, at)
        field = of.fields_by_number.get(key >> 3)
        if field is None:
            raise ValueError(f"unknown field {key >> 3}")
        size, many, name = _WIDTHS.get(key & 7, 0), 0, prefix + field.name
        if key & 7 == _LENGTH_DELIMITED:
            size, at = read_varint(payload, at)
        if at + size > end:
            raise ValueError(f"field {name} is cut")
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            if key & 7 != _LENGTH_DELIMITED or field.is_repeated or not size:
                raise ValueError(f"field {name} is no message with numbers")
            assert field.message_type is not None
            within.append((field.message_type, f"{name}_", at + size))
            continue
        code, wire = _CODES.get(field.type, ("", -1))
        if field.is_repeated:
            many, rest = divmod(size, _WIDTHS.get(wire, 1))
            if key & 7 != _LENGTH_DELIMITED or wire <= 0 or rest or not many:
                raise ValueError(f"field {name} is no column")
        elif key & 7 != wire:
            raise ValueError(f"field {name} is not of fixed width")
        yield Piece(name, payload[start:at], code, many)
        at += size
        start = at
    if start != at:
        raise ValueError("a message without numbers")
