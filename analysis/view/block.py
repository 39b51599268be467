"""Packs arrays so that a page can use them without parsing: a header, then the arrays themselves.

The header is a JSON object after its length (4 bytes, little endian). It has a list of arrays, each
with its name, type and shape. Header and arrays are padded to multiples of 8 bytes.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray


def pack(**arrays: NDArray[Any]) -> bytes:
    """Return the block with these arrays."""
    listed = [[name, array.dtype.name, list(array.shape)] for name, array in arrays.items()]
    head = json.dumps({"arrays": listed}, separators=(",", ":")).encode()
    head += b" " * (-(len(head) + 4) % 8)
    parts = [len(head).to_bytes(4, "little"), head]
    for array in arrays.values():
        data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
        parts += [data, b"\0" * (-len(data) % 8)]
    return b"".join(parts)
