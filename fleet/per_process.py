"""How many vehicles share a process: a number, or as the processors of the machine suggest."""

from __future__ import annotations

import os
from typing import Final

AUTO: Final = "auto"

MANY: Final = 50
"""Processes per processor; more of them take long to start, and may miss the stall limit."""


class PerProcessError(ValueError):
    """A number of vehicles per process that cannot be; the text says why."""


def per_process_of(asked: int | str, size: int, cores: int | None = None) -> int:
    """Return how many vehicles of a fleet of `size` share a process; raises PerProcessError.

    `asked` is a number, as an int or as text, or AUTO: a process for each of the `cores`, by
    default those that this process may use. Then no vehicle is left alone at the end of the fleet.
    """
    if asked == AUTO:
        return _for_cores(size, cores_here() if cores is None else cores)
    try:
        number = int(asked)
    except ValueError:
        text = f"{asked}: is no number of vehicles; allowed: 1 or more, or {AUTO}"
        raise PerProcessError(text) from None
    if number < 1:
        raise PerProcessError(f"{asked}: is not at least 1")
    return number


def crowd(size: int, per_process: int, cores: int | None = None) -> str | None:
    """Return what helps if the processes of `size` vehicles are many for the machine, else None.

    `cores` are by default those that this process may use.
    """
    cores = cores_here() if cores is None else cores
    processes = -(-size // per_process)
    if processes <= MANY * cores:
        return None
    here = "1 processor" if cores == 1 else f"{cores} processors"
    return (
        f"{processes} processes of vehicles share {here}, and may not all start within the stall "
        f"limit; --vehicles-per-process {AUTO} starts one for each processor"
    )


def cores_here() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0))


def _for_cores(size: int, cores: int) -> int:
    number = -(-size // cores)
    while number > 1 and size % number == 1:
        number += 1
    return number
