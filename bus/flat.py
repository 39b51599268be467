"""Serializes messages that consist of numbers of fixed width, with one call of `struct`.

Such a message always has the same length and the same tags. Building the protobuf object first
takes several times as long, in every vehicle and cycle.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

from google.protobuf.descriptor import Descriptor, FieldDescriptor

from zenvoy.bus.packed import tag, varint

CODES: Final = {
    FieldDescriptor.TYPE_DOUBLE: ("d", 1),
    FieldDescriptor.TYPE_SFIXED64: ("q", 1),
    FieldDescriptor.TYPE_FIXED64: ("Q", 1),
    FieldDescriptor.TYPE_FLOAT: ("f", 5),
    FieldDescriptor.TYPE_SFIXED32: ("i", 5),
    FieldDescriptor.TYPE_FIXED32: ("I", 5),
    FieldDescriptor.TYPE_ENUM: ("B", 0),  # a varint of one byte: values below 128
}
"""The `struct` code of a number, and its wire type, by type of field."""


class Piece(NamedTuple):
    """A part of a message: the bytes before its numbers, their `struct` code, and how many.

    many is 0 for a single number that is no column.
    """

    name: str
    head: bytes
    code: str
    many: int = 0


class FlatEncoder:
    """An encoder of one message type, without the fields in `leave_out`.

    Fields are single numbers, enums below 128, or messages of these. Raises TypeError for any other
    field that is not left out. The name of a nested field has both names: `gap` of `ahead` is
    `ahead_gap`.
    """

    encode: Callable[..., bytes]
    """Serializes a message from its numbers, each given by the name of its field.

    Raises TypeError if a field is missing, unknown or given without its name, and struct.error if a
    number is out of range.
    """

    def __init__(self, descriptor: Descriptor, leave_out: tuple[str, ...] = ()) -> None:
        numbers = list(_numbers(descriptor, leave_out))
        self.names = tuple(number.name for number in numbers)
        """The names of the fields, in order of field number."""
        self.pieces = tuple(Piece(number.name, number.head, number.code) for number in numbers)
        """The parts of a message, in order."""
        self.encode = _compiled(numbers)


def alone(descriptor: Descriptor, name: str) -> FlatEncoder:
    """Return an encoder of one field, to be appended to a serialized message."""
    others = tuple(field.name for field in descriptor.fields if field.name != name)
    return FlatEncoder(descriptor, leave_out=others)


class ColumnEncoder:
    """An encoder of a repeated field of one message type, for a few numbers of fixed width.

    For many numbers use `packed`: the cost of an array hardly depends on their number.
    """

    def __init__(self, descriptor: Descriptor, name: str) -> None:
        field = descriptor.fields_by_name[name]
        self._name, self._number = name, field.number
        self._code, wire = CODES.get(field.type, ("", 0))
        if not field.is_repeated or not wire:
            raise TypeError(f"{descriptor.name}.{name} is not a column of numbers of fixed width")

    def encode(self, values: Sequence[Any]) -> bytes:
        """Return the field, to be appended to a serialized message; b"" if it is empty.

        Raises struct.error if a number is out of range.
        """
        if not values:
            return b""
        head, form = _column(self._number, self._code, len(values))
        return form.pack(head, *values)

    def piece(self, count: int) -> Piece:
        """Return the field with this many numbers, 1 or more, as a part of a message."""
        return Piece(self._name, _column(self._number, self._code, count)[0], self._code, count)


@cache
def _column(number: int, code: str, count: int) -> tuple[bytes, struct.Struct]:
    """Return the bytes before the numbers of a column, and the format of the whole field."""
    head = tag(number, 2) + varint(count * struct.calcsize("<" + code))
    return head, struct.Struct(f"<{len(head)}s{count}{code}")


class _Number(NamedTuple):
    """A number of a message: its name, the bytes before it, and its `struct` code."""

    name: str
    head: bytes
    code: str

    @property
    def size(self) -> int:
        """The length of the number and its head, bytes."""
        return len(self.head) + struct.calcsize("<" + self.code)


def _numbers(descriptor: Descriptor, leave_out: tuple[str, ...]) -> Iterator[_Number]:
    """Yield the numbers of a message in order of field number, nested messages in place.

    The head of a number is the tag of its field. A nested message begins with its own tag and
    length; these become part of the head of its first number.
    """
    for field in sorted(descriptor.fields, key=lambda field: field.number):
        if field.name in leave_out:
            continue
        if field.is_repeated or field.type not in {*CODES, FieldDescriptor.TYPE_MESSAGE}:
            raise TypeError(f"{descriptor.name}.{field.name} is not a number of fixed width")
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            assert field.message_type is not None
            inner = list(_numbers(field.message_type, ()))
            head = tag(field.number, 2) + varint(sum(number.size for number in inner))
            inner[0] = inner[0]._replace(head=head + inner[0].head)
            yield from (number._replace(name=f"{field.name}_{number.name}") for number in inner)
            continue
        code, wire = CODES[field.type]
        yield _Number(field.name, tag(field.number, wire), code)


def _compiled(numbers: Sequence[_Number]) -> Callable[..., bytes]:
    """Return a function that takes each number by keyword and packs them in order of field.

    For the heads and names `(b"\r", "cycle"), (b"\x11", "time_ns")` it is

        lambda *, cycle, time_ns: pack(b"\r", cycle, b"\x11", time_ns)

    compiled from source text, because then the interpreter matches keywords to fields. That costs
    less than looking up each keyword and copying a list of arguments. All names come from
    messages.proto.
    """
    names = [number.name for number in numbers]
    if len(set(names)) < len(names):
        raise TypeError(f"two fields have one name: {', '.join(names)}")
    form = struct.Struct("<" + "".join(f"{len(one.head)}s{one.code}" for one in numbers))
    arguments = ", ".join(f"{number.head!r}, {number.name}" for number in numbers)
    source = f"lambda *, {', '.join(names)}: pack({arguments})"
    function: Callable[..., bytes] = eval(source, {"pack": form.pack})
    return function
