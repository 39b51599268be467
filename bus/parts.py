"""Splits payloads that are too large for the transport, and joins their parts."""

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
_MAX_PARTS: Final = 4_096
# Memory for incomplete payloads, whose missing parts may never arrive.
_MAX_KEPT_BYTES: Final = 64_000_000
_OVERHEAD_BYTES: Final = 500  # per piece, in memory


def split(payload: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield the pieces of a payload, each with an attachment.

    The attachment holds the number of the part, the number of parts, and the CRC-32 of the whole.
    """
    parts, checksum = -(-len(payload) // MAX_PAYLOAD_BYTES), crc32(payload)
    for part in range(parts):
        start = part * MAX_PAYLOAD_BYTES
        yield payload[start : start + MAX_PAYLOAD_BYTES], _PART.pack(part, parts, checksum)


class Joiner:
    """Joins pieces into payloads, even if pieces of several payloads are interleaved.

    The checksum tells which pieces belong to one payload. If incomplete payloads take too much
    memory, the oldest are dropped.
    """

    def __init__(self, max_kept_bytes: int = _MAX_KEPT_BYTES) -> None:
        self._pieces: dict[Hashable, dict[int, bytes]] = {}
        self._max_kept_bytes = max_kept_bytes
        self._kept_bytes = 0

    def join(self, stream: Hashable, piece: bytes, attachment: bytes) -> bytes | None:
        """Return the whole payload once its last piece has arrived, and None before.

        Raises PayloadError if the attachment is not valid, if a piece comes twice, or if the whole
        does not match its checksum.
        """
        if len(attachment) != _PART.size:
            raise PayloadError(f"an attachment of {len(attachment)} bytes")
        part, parts, checksum = _PART.unpack(attachment)
        if not part < parts <= _MAX_PARTS or len(piece) > MAX_PAYLOAD_BYTES:
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
            raise PayloadError(f"the whole of {parts} parts does not match its checksum")
        return whole

    def _drop_oldest(self) -> None:
        while self._kept_bytes > self._max_kept_bytes and len(self._pieces) > 1:
            self._forget(next(iter(self._pieces)))

    def _forget(self, payload: Hashable) -> None:
        pieces = self._pieces.pop(payload, {})
        self._kept_bytes -= sum(map(_size, pieces.values()))


def _size(piece: bytes) -> int:
    return len(piece) + _OVERHEAD_BYTES
