"""The memory of a process that runs for hours."""

from __future__ import annotations

import ctypes
from typing import Final

_M_MMAP_THRESHOLD: Final = -3  # of malloc.h
_LARGE: Final = 128 << 10  # bytes; the initial threshold of glibc


def give_back_large_blocks() -> None:
    """Make the C library return blocks of 128 KiB and more to the system as soon as they are freed.

    glibc raises its threshold as larger blocks are freed. Then the buffers of chunks, a megabyte
    each, lie on the heap among small blocks, which keep the heap from shrinking. This has no effect
    if the C library has no such setting.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_THRESHOLD, _LARGE)
