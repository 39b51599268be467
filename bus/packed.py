"""Converts columns of numbers to and from protobuf's packed fixed-width fields, with numpy.

A packed repeated field of fixed width is an array already: its numbers, little endian, one after
the other. Filling a repeated field element by element takes 20 to 50 times as long.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, lru_cache
from typing import Any, Final

import numpy as np
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from numpy.typing import NDArray

_DTYPES: Final[dict[int, np.dtype[Any]]] = {
    FieldDescriptor.TYPE_DOUBLE: np.dtype("<f8"),
    FieldDescriptor.TYPE_FLOAT: np.dtype("<f4"),
    FieldDescriptor.TYPE_FIXED32: np.dtype("<u4"),
    FieldDescriptor.TYPE_FIXED64: np.dtype("<u8"),
    FieldDescriptor.TYPE_SFIXED32: np.dtype("<i4"),
    FieldDescriptor.TYPE_SFIXED64: np.dtype("<i8"),
}
_LENGTH_DELIMITED: Final = 2
_LONGEST_VARINT: Final = 28  # bits before the last byte; protobuf refuses longer tags and lengths


class PackedCodec:
    """Encodes and decodes the fixed-width fields, single or repeated, of one message type.

    Raises TypeError for a message type that has any other field.
    """

    def __init__(self, descriptor: Descriptor) -> None:
        self._tags: dict[str, tuple[bytes, np.dtype[Any], bool]] = {}
        self._fields: dict[int, tuple[str, np.dtype[Any], bool]] = {}
        for field in descriptor.fields:
            dtype = _DTYPES.get(field.type)
            if dtype is None:
                raise TypeError(f"{descriptor.name}.{field.name} is not of fixed width")
            repeated = bool(field.is_repeated)
            wire = _LENGTH_DELIMITED if repeated else (1 if dtype.itemsize == 8 else 5)
            self._tags[field.name] = (tag(field.number, wire), dtype, repeated)
            self._fields[field.number << 3 | wire] = (field.name, dtype, repeated)

    def encode(self, **values: Any) -> bytes:
        """Return the serialized message, without fields left out and empty columns."""
        parts: list[bytes] = []
        for name, value in values.items():
            head, dtype, repeated = self._tags[name]
            data = np.asarray(value, dtype=dtype).tobytes()
            if not repeated:
                parts += (head, data)
            elif data:
                parts += (head, varint(len(data)), data)
        return b"".join(parts)

    def encode_each(self, ends: NDArray[np.int64], **columns: NDArray[Any]) -> Iterator[bytes]:
        """Yield the serialized columns of several messages, whose rows follow each other.

        ends: by message, how many rows it and those before it have.
        """
        found = []
        for name, column in columns.items():
            head, dtype, _ = self._tags[name]
            found.append((head, dtype.itemsize, column.astype(dtype).tobytes()))
        start = 0
        for end in ends.tolist():
            parts: list[bytes] = []
            for head, width, data in found if end > start else ():
                parts += (head, varint(width * (end - start)), data[width * start : width * end])
            yield b"".join(parts)
            start = end

    def decode(self, payload: bytes | memoryview) -> dict[str, NDArray[Any]]:
        """Return an array for each field, by name: 1-d for repeated fields, 0-d for single ones.

        Absent fields are empty or 0. Raises ValueError as `spans` does.
        """
        found: dict[str, NDArray[Any]] = {
            name: np.zeros(0 if repeated else (), dtype)
            for name, (_, dtype, repeated) in self._tags.items()
        }
        for name, (at, size) in self.spans(payload).items():
            _, dtype, repeated = self._tags[name]
            column = np.frombuffer(payload, dtype, size // dtype.itemsize, at)
            found[name] = column if repeated else column.reshape(())
        return found

    def spans(self, payload: bytes | memoryview) -> dict[str, tuple[int, int]]:
        """Return where the numbers of each field present begin, and their size, in bytes.

        Raises ValueError if the payload has a field that the type does not have, is cut, or has a
        column in pieces (which no encoder of this project writes).
        """
        found: dict[str, tuple[int, int]] = {}
        at = 0
        while at < len(payload):
            key, at = read_varint(payload, at)
            if key not in self._fields:
                raise ValueError(f"unknown field {key >> 3} (wire type {key & 7})")
            name, dtype, repeated = self._fields[key]
            size = dtype.itemsize
            if repeated:
                size, at = read_varint(payload, at)
            if at + size > len(payload):
                raise ValueError(f"field {name} is cut")
            if size % dtype.itemsize:
                raise ValueError(f"field {name} ends within a number")
            if repeated and found.get(name, (0, 0))[1]:
                raise ValueError(f"field {name} comes in pieces")
            found[name] = at, size
            at += size
        return found

    def with_column(self, payload: bytes, name: str, values: NDArray[Any]) -> bytes:
        """Return the message with the numbers of a column replaced by as many others.

        Raises ValueError as `spans` does, and if the number of values differs.
        """
        _, dtype, _ = self._tags[name]
        at, size = self.spans(payload).get(name, (0, 0))
        data = np.asarray(values, dtype=dtype).tobytes()
        if len(data) != size:
            raise ValueError(
                f"field {name} has {size // dtype.itemsize} numbers, not {len(values)}"
            )
        return payload[:at] + data + payload[at + size :]

    def fields(self) -> dict[str, tuple[np.dtype[Any], bool]]:
        """Return the type of the numbers of each field, and whether it is a column, by name."""
        return {name: (dtype, repeated) for name, (_, dtype, repeated) in self._tags.items()}


def encode_bytes(number: int, payload: bytes) -> bytes:
    """Return one value of a bytes or message field, to be appended to a serialized message."""
    return tag(number, _LENGTH_DELIMITED) + varint(len(payload)) + payload


@cache
def tag(number: int, wire: int) -> bytes:
    """Return the tag of a field, which comes before its value: its number and wire type."""
    return varint(number << 3 | wire)


@lru_cache(maxsize=1_024)  # the same lengths occur again and again
def varint(value: int) -> bytes:
    """Return a number of 0 or more in protobuf's variable-width encoding."""
    parts = bytearray()
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    parts.append(value)
    return bytes(parts)


def read_varint(payload: bytes | memoryview, at: int) -> tuple[int, int]:
    """Return the tag or length that begins at a place, and where it ends.

    Raises ValueError if it is cut, or longer than protobuf allows.
    """
    value = shift = 0
    while True:
        if at >= len(payload) or shift > _LONGEST_VARINT:
            raise ValueError("a tag or a length is cut, or too long")
        byte = payload[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value, at
        shift += 7
