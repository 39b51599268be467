"""Processes that run vehicles: which vehicles each runs, and what it is called."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

from zenvoy.bus.topics import vehicle_name


class VehicleProcess(NamedTuple):
    """The vehicles that a process runs, ascending, and its name."""

    name: str
    vehicles: tuple[int, ...]

    @property
    def is_shared(self) -> bool:
        """Whether it runs several vehicles. Then their messages go in bundles, on its own keys."""
        return len(self.vehicles) > 1


def vehicle_processes(
    size: int, per_process: int, without: Collection[int] = ()
) -> tuple[VehicleProcess, ...]:
    """Processes of the vehicles 1 to `size` but for those `without`, `per_process` neighbours each.

    A vehicle whose neighbours are all left out has a process of its own, as by default.
    """
    found = []
    for first in range(1, size + 1, per_process):
        last = min(size, first + per_process - 1)
        vehicles = tuple(one for one in range(first, last + 1) if one not in without)
        if len(vehicles) == 1:
            found.append(VehicleProcess(vehicle_name(vehicles[0], size), vehicles))
        elif vehicles:
            ends = (vehicle_name(end, size).partition("-")[2] for end in (first, last))
            found.append(VehicleProcess("-".join(("vehicles", *ends)), vehicles))
    return tuple(found)
