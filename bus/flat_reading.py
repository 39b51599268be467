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
_MOST_OF_A_SIZE: Final = 8  # that are kept of one size
_MOST_NEW: Final = 20  # per read; 40 vehicles have 14 in their first cycle, and few later
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

    It reads no message that protobuf refuses. It leaves these to protobuf: messages with unknown
    fields, with fields that come twice, with larger enums, above 16 kB, or without numbers. In one
    read it looks for 20 new forms at most, and leaves all others to protobuf, too.
    """

    def __init__(self, descriptor: Descriptor) -> None:
        self._descriptor = descriptor
        self._forms: dict[int, list[FlatTable]] = {}  # by size of their messages

    def read(self, payloads: Sequence[bytes]) -> list[Alike] | None:
        """Return the messages, grouped by form; None if any is left to protobuf.

        The name of a field in a nested message has both names: `gap` of `ahead` is `ahead_gap`.
        Fields that a message leaves out are missing from its group.
        """
        found, left = self.read_most(payloads)
        return None if left else found

    def read_most(self, payloads: Sequence[bytes]) -> tuple[list[Alike], list[int]]:
        """Return messages as `read` does, and the places of those that are left to protobuf."""
        by_size = defaultdict[int, list[int]](list)
        for place, payload in enumerate(payloads):
            by_size[len(payload)].append(place)
        found, left, more = list[Alike](), list[int](), _MOST_NEW
        for size, rows in by_size.items():
            at = np.array(rows)
            while len(at):
                data = b"".join([payloads[row] for row in at.tolist()])
                form = self._known(data[:size])
                if form is None and (not more or size > _LARGEST):
                    left += at.tolist()
                    break
                if form is None:
                    more -= 1
                    form = self._found(data[:size])
                if form is None:
                    left.append(int(at[0]))
                    at = at[1:]
                    continue
                fits = form.fits(data)
                fields = form.rows(data)[fits]
                is_whole = np.ones(len(fields), dtype=np.bool_)
                for name in form.varints:
                    is_whole &= fields[name] <= _LARGEST_VARINT
                found.append(Alike(at[fits][is_whole], fields[is_whole]))
                left += at[fits][~is_whole].tolist()
                at = at[~fits]
        return [one for one in found if len(one.at)], left

    def _known(self, payload: bytes) -> FlatTable | None:
        """Return the form of a message if an earlier one had it."""
        forms = self._forms.get(len(payload), ())
        return next((form for form in forms if form.fits(payload).all()), None)

    def _found(self, payload: bytes) -> FlatTable | None:
        """Return the form of a message, and keep it; None if it is not flat."""
        pieces = _form_of(self._descriptor, payload)
        if pieces is None:
            return None
        if sum(map(len, self._forms.values())) >= _MOST_FORMS:
            del self._forms[next(iter(self._forms))]
        forms = self._forms.setdefault(len(payload), [])
        forms.append(FlatTable(pieces))
        del forms[:-_MOST_OF_A_SIZE]
        return forms[-1]


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
