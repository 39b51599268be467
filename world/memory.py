"""Memory of a process that runs for hours."""

from __future__ import annotations

import ctypes
from typing import Final

_M_MMAP_THRESHOLD: Final = -3  # of malloc.h
_LARGE: Final = 128 << 10  # bytes; where the threshold of glibc begins


def give_back_large_blocks() -> None:
    """Have blocks of 128 KiB and more go back to the system as soon as they are freed.

    glibc raises its threshold with the blocks that are freed: the buffers of a chunk, a megabyte
    each, then lie on the heap among small ones, which keep it from shrinking. Without effect where
    the C library has no such setting.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE)
