"""Payloads larger than the transport carries, in parts and together again."""

from __future__ import annotations

import struct
from collections.abc import Hashable, Iterator
from typing import Final
from zlib import crc32

from zenvoy.bus.errors import PayloadError

# The low-latency transport drops messages of about 65,400 bytes and more without an error, and
# resets the link.
MAX_PAYLOAD_BYTES: Final = 60_000
_PART: Final = struct.Struct("<III")
_MOST_PARTS: Final = 4_096
# What is kept of payloads of which parts are missing, perhaps for ever.
_MOST_KEPT_BYTES: Final = 64_000_000
_OVERHEAD_BYTES: Final = 500  # of a piece, however small


def split(payload: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Pieces of a payload, each with its attachment: part, number of parts, CRC-32 of the whole."""
    parts, checksum = -(-len(payload) // MAX_PAYLOAD_BYTES), crc32(payload)
    for part in range(parts):
        start = part * MAX_PAYLOAD_BYTES
        yield payload[start : start + MAX_PAYLOAD_BYTES], _PART.pack(part, parts, checksum)


class Joiner:
    """Puts pieces together, whatever comes between those of a payload.

    The checksum says what belongs together. Pieces that others never follow are dropped in the
    end, the oldest first.
    """

    def __init__(self, most_kept_bytes: int = _MOST_KEPT_BYTES) -> None:
        self._pieces: dict[Hashable, dict[int, bytes]] = {}
        self._most_kept_bytes = most_kept_bytes
        self._kept_bytes = 0

    def join(self, stream: Hashable, piece: bytes, attachment: bytes) -> bytes | None:
        """Whole payload with its last piece, None before.

        Raises PayloadError where the attachment makes no sense, where a piece came before, and
        where the whole is not what its checksum says.
        """
        if len(attachment) != _PART.size:
            raise PayloadError(f"an attachment of {len(attachment)} bytes")
        part, parts, checksum = _PART.unpack(attachment)
        if not part < parts <= _MOST_PARTS or len(piece) > MAX_PAYLOAD_BYTES:
            raise PayloadError(f"part {part} of {parts}, of {len(piece)} bytes")
        payload = stream, parts, checksum
        pieces = self._pieces.get(payload, {})
        if part in pieces:
            raise PayloadError(f"part {part} of {parts} comes again")
        if len(pieces) + 1 < parts:
            self._pieces[payload] = pieces
            pieces[part] = piece
            self._kept_bytes += _size(piece)
            self._drop_oldest()
            return None
        self._forget(payload)
        whole = b"".join(({**pieces, part: piece})[number] for number in range(parts))
        if crc32(whole) != checksum:
            raise PayloadError(f"{parts} parts do not make the whole")
        return whole

    def _drop_oldest(self) -> None:
        while self._kept_bytes > self._most_kept_bytes and len(self._pieces) > 1:
            self._forget(next(iter(self._pieces)))

    def _forget(self, payload: Hashable) -> None:
        pieces = self._pieces.pop(payload, {})
        self._kept_bytes -= sum(map(_size, pieces.values()))


def _size(piece: bytes) -> int:
    return len(piece) + _OVERHEAD_BYTES
