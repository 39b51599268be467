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

    by_name: Callable[..., bytes]
    """Serializes a message from its numbers, each given by the name of its field.

    Raises TypeError where a field is missing, unknown or given without its name, and struct.error
    where a number's range does not fit.
    """

    def __init__(self, descriptor: Descriptor, leave_out: tuple[str, ...] = ()) -> None:
        parts = list(_parts(descriptor, leave_out))
        self.names = tuple(part.name for part in parts)
        """Names of the fields, in order of field number."""
        form = "".join(f"{len(part.head)}s{part.code}" for part in parts)
        self._struct = struct.Struct("<" + form)
        self._arguments = [argument for part in parts for argument in (part.head, 0)]
        self.by_name = _compiled(self._struct, parts)

    def encode(self, *values: Any) -> bytes:
        """Serialize a message from its numbers in order of `names`; prefer `by_name`.

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


class _Part(NamedTuple):
    """A number of a message: its name, the bytes before it (tag), and its `struct` code."""

    name: str
    head: bytes
    code: str

    @property
    def size(self) -> int:
        """Bytes of the number and of what stands before it."""
        return len(self.head) + struct.calcsize("<" + self.code)


def _parts(descriptor: Descriptor, leave_out: tuple[str, ...]) -> Iterator[_Part]:
    """The numbers of a message in order of field number, those of nested messages in place.

    A nested message begins with its own tag and its length. Both stand before its first number,
    and so become a part of that number's head.
    """
    for field in sorted(descriptor.fields, key=lambda field: field.number):
        if field.name in leave_out:
            continue
        if field.is_repeated or field.type not in {*_CODES, FieldDescriptor.TYPE_MESSAGE}:
            raise TypeError(f"{descriptor.name}.{field.name} is not a number of fixed width")
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            assert field.message_type is not None
            inner = list(_parts(field.message_type, ()))
            head = tag(field.number, 2) + varint(sum(part.size for part in inner))
            inner[0] = inner[0]._replace(head=head + inner[0].head)
            yield from (part._replace(name=f"{field.name}_{part.name}") for part in inner)
            continue
        code, wire = _CODES[field.type]
        yield _Part(field.name, tag(field.number, wire), code)


def _compiled(form: struct.Struct, parts: Sequence[_Part]) -> Callable[..., bytes]:
    """A function with a keyword for each part, in any order, that packs them in theirs.

    The interpreter matches keywords to fields, which costs less than to copy a list of arguments.
    All names come from messages.proto.
    """
    names = [part.name for part in parts]
    if len(set(names)) < len(names):
        raise TypeError(f"two fields have one name: {', '.join(names)}")
    arguments = ", ".join(f"{part.head!r}, {part.name}" for part in parts)
    source = f"lambda *, {', '.join(names)}: pack({arguments})"
    function: Callable[..., bytes] = eval(source, {"pack": form.pack})
    return function
