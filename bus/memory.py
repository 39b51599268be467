"""The memory of a process that runs for hours, and needs large blocks in every cycle."""

from __future__ import annotations

import ctypes
from typing import Final

_M_TRIM_THRESHOLD: Final = -1  # of malloc.h
_M_MMAP_THRESHOLD: Final = -3
_LARGE: Final = 128 << 10  # bytes; the initial threshold of glibc
_LARGEST: Final = 32 << 20  # the greatest that glibc allows


def give_back_large_blocks() -> None:
    """Make the C library return blocks of 128 KiB and more to the system as soon as they are freed.

    glibc raises its threshold as larger blocks are freed. Then the buffers of chunks, a megabyte
    each, lie on the heap among small blocks, which keep the heap from shrinking. This has no effect
    if the C library has no such setting.
    """
    _set(_M_MMAP_THRESHOLD, _LARGE)


def keep_large_blocks() -> None:
    """Make the C library keep what is freed, up to 32 MiB, for the next cycle.

    Otherwise the columns of the frames of a large fleet, 52,000 for a thousand vehicles, come with
    fresh pages in every cycle, and each page costs a fault. This has no effect if the C library has
    no such setting.
    """
    _set(_M_MMAP_THRESHOLD, _LARGEST)
    _set(_M_TRIM_THRESHOLD, _LARGEST)


def _set(parameter: int, value: int) -> None:
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(parameter, value)
