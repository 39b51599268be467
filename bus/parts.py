"""Payloads larger than the transport carries, in parts and together again."""

from __future__ import annotations

import struct
from collections.abc import Hashable, Iterator
from typing import Final

from zenvoy.bus.errors import PayloadError

# The low-latency transport drops messages of about 65,400 bytes and more without an error, and
# resets the link.
MAX_PAYLOAD_BYTES: Final = 60_000
_PART: Final = struct.Struct("<II")


def split(payload: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Pieces of a payload, each with its attachment: part and number of parts."""
    parts = -(-len(payload) // MAX_PAYLOAD_BYTES)
    for part in range(parts):
        start = part * MAX_PAYLOAD_BYTES
        yield payload[start : start + MAX_PAYLOAD_BYTES], _PART.pack(part, parts)


class Joiner:
    """Puts pieces together, stream by stream; those of one stream come in order."""

    def __init__(self) -> None:
        self._pieces: dict[Hashable, list[bytes]] = {}

    def join(self, stream: Hashable, piece: bytes, attachment: bytes) -> bytes | None:
        """Whole payload with its last piece, None before; raises PayloadError on disorder."""
        if len(attachment) != _PART.size:
            raise PayloadError(f"an attachment of {len(attachment)} bytes")
        part, parts = _PART.unpack(attachment)
        pieces = self._pieces.setdefault(stream, [])
        if part == 0:
            pieces.clear()
        if part != len(pieces) or part >= parts:
            raise PayloadError(f"part {part} of {parts} after {len(pieces)}")
        pieces.append(piece)
        if len(pieces) < parts:
            return None
        del self._pieces[stream]
        return b"".join(pieces)
