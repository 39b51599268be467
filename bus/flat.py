"""Serializes messages that are all numbers of fixed width, in one go.

Such a message has the same length and the same tags whatever it says, so one `struct` call writes
it. Building the protobuf object first costs several times as much, in every vehicle and cycle.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

from google.protobuf.descriptor import Descriptor, FieldDescriptor

from zenvoy.bus.packed import tag, varint

_CODES: Final = {
    FieldDescriptor.TYPE_DOUBLE: ("d", 1),
    FieldDescriptor.TYPE_SFIXED64: ("q", 1),
    FieldDescriptor.TYPE_FIXED64: ("Q", 1),
    FieldDescriptor.TYPE_FLOAT: ("f", 5),
    FieldDescriptor.TYPE_SFIXED32: ("i", 5),
    FieldDescriptor.TYPE_FIXED32: ("I", 5),
    FieldDescriptor.TYPE_ENUM: ("B", 0),  # a varint of one byte: values below 128
}


class FlatEncoder:
    """Encoder of one message type, without the fields in `leave_out`.

    Fields are single numbers, enums below 128, or messages of such; raises TypeError where one
    that is not left out is something else. A field of a nested message is called by both names:
    `gap` of `ahead` is `ahead_gap`.
    """

    encode: Callable[..., bytes]
    """Serializes a message from its numbers, each given by the name of its field.

    Raises TypeError where a field is missing, unknown or given without its name, and struct.error
    where a number's range does not fit.
    """

    def __init__(self, descriptor: Descriptor, leave_out: tuple[str, ...] = ()) -> None:
        numbers = list(_numbers(descriptor, leave_out))
        self.names = tuple(number.name for number in numbers)
        """Names of the fields, in order of field number."""
        self.encode = _compiled(numbers)


def alone(descriptor: Descriptor, name: str) -> FlatEncoder:
    """Return an encoder of one field, to be appended to a serialized message."""
    others = tuple(field.name for field in descriptor.fields if field.name != name)
    return FlatEncoder(descriptor, leave_out=others)


class ColumnEncoder:
    """Encoder of a repeated field of one message type, for a few numbers of fixed width.

    For many of them there is `packed`: arrays cost more, but not by the number.
    """

    def __init__(self, descriptor: Descriptor, name: str) -> None:
        field = descriptor.fields_by_name[name]
        self._number = field.number
        self._code, wire = _CODES.get(field.type, ("", 0))
        if not field.is_repeated or not wire:
            raise TypeError(f"{descriptor.name}.{name} is not a column of numbers of fixed width")

    def encode(self, values: Sequence[Any]) -> bytes:
        """The field, to be appended to a serialized message; nothing where it is empty.

        Raises struct.error where a number's range does not fit.
        """
        if not values:
            return b""
        head, form = _column(self._number, self._code, len(values))
        return form.pack(head, *values)


@cache
def _column(number: int, code: str, count: int) -> tuple[bytes, struct.Struct]:
    """What stands before the numbers of a column, and the format of it all."""
    head = tag(number, 2) + varint(count * struct.calcsize("<" + code))
    return head, struct.Struct(f"<{len(head)}s{count}{code}")


class _Number(NamedTuple):
    """A number of a message: its name, the bytes before it, and its `struct` code."""

    name: str
    head: bytes
    code: str

    @property
    def size(self) -> int:
        """Bytes of the number and of what stands before it."""
        return len(self.head) + struct.calcsize("<" + self.code)


def _numbers(descriptor: Descriptor, leave_out: tuple[str, ...]) -> Iterator[_Number]:
    """The numbers of a message in order of field number, those of nested messages in place.

    The head of a number is the tag of its field. A nested message begins with its own tag and its
    length; these two are put before the tag of its first number, and so become part of its head.
    """
    for field in sorted(descriptor.fields, key=lambda field: field.number):
        if field.name in leave_out:
            continue
        if field.is_repeated or field.type not in {*_CODES, FieldDescriptor.TYPE_MESSAGE}:
            raise TypeError(f"{descriptor.name}.{field.name} is not a number of fixed width")
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            assert field.message_type is not None
            inner = list(_numbers(field.message_type, ()))
            head = tag(field.number, 2) + varint(sum(number.size for number in inner))
            inner[0] = inner[0]._replace(head=head + inner[0].head)
            yield from (number._replace(name=f"{field.name}_{number.name}") for number in inner)
            continue
        code, wire = _CODES[field.type]
        yield _Number(field.name, tag(field.number, wire), code)


def _compiled(numbers: Sequence[_Number]) -> Callable[..., bytes]:
    """A function with a keyword for each number, in any order, that packs them in theirs.

    For the heads and names `(b"\r", "cycle"), (b"\x11", "time_ns")` it is

        lambda *, cycle, time_ns: pack(b"\r", cycle, b"\x11", time_ns)

    as source text, because then the interpreter matches keywords to fields: that costs less than
    to look each one up and to copy a list of arguments. All names come from messages.proto.
    """
    names = [number.name for number in numbers]
    if len(set(names)) < len(names):
        raise TypeError(f"two fields have one name: {', '.join(names)}")
    form = struct.Struct("<" + "".join(f"{len(one.head)}s{one.code}" for one in numbers))
    arguments = ", ".join(f"{number.head!r}, {number.name}" for number in numbers)
    source = f"lambda *, {', '.join(names)}: pack({arguments})"
    function: Callable[..., bytes] = eval(source, {"pack": form.pack})
    return function
