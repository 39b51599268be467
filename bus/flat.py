"""Serializes messages that are all numbers of fixed width, in one go.

Such a message has the same length and the same tags whatever it says, so one `struct` call writes
it. Building the protobuf object first costs several times as much, in every vehicle and cycle.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any, Final

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
    that is not left out is something else.
    """

    def __init__(self, descriptor: Descriptor, leave_out: tuple[str, ...] = ()) -> None:
        form, self._arguments, _ = _flatten(descriptor, leave_out)
        self._struct = struct.Struct("<" + form)

    def encode(self, *values: Any) -> bytes:
        """Serialized message from its numbers in order of field number, nested ones in place.

        Raises struct.error where their number or a number's range does not fit.
        """
        if 2 * len(values) != len(self._arguments):
            raise struct.error(f"{len(self._arguments) // 2} numbers wanted, not {len(values)}")
        arguments = self._arguments.copy()
        arguments[1::2] = values
        return self._struct.pack(*arguments)


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


def _flatten(descriptor: Descriptor, leave_out: tuple[str, ...]) -> tuple[str, list[Any], int]:
    """Format, arguments (tags, each before the place of its number), and size in bytes."""
    form, size = "", 0
    arguments: list[Any] = []
    for field in sorted(descriptor.fields, key=lambda field: field.number):
        if field.name in leave_out:
            continue
        if field.is_repeated or field.type not in {*_CODES, FieldDescriptor.TYPE_MESSAGE}:
            raise TypeError(f"{descriptor.name}.{field.name} is not a number of fixed width")
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            assert field.message_type is not None
            inner_form, inner, inner_size = _flatten(field.message_type, ())
            head = tag(field.number, 2) + varint(inner_size)
            inner[0] = head + inner[0]
            inner_form = f"{len(inner[0])}s" + inner_form.partition("s")[2]
            form, arguments = form + inner_form, arguments + inner
            size += len(head) + inner_size
            continue
        code, wire = _CODES[field.type]
        head = tag(field.number, wire)
        form, arguments = form + f"{len(head)}s{code}", [*arguments, head, 0]
        size += len(head) + struct.calcsize("<" + code)
    return form, arguments, size
