"""Processes that run vehicles: their names, and which vehicles each runs."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

from zenvoy.bus.topics import vehicle_name


class VehicleProcess(NamedTuple):
    """The name of a process, and the vehicles that it runs, ascending."""

    name: str
    vehicles: tuple[int, ...]

    @property
    def is_shared(self) -> bool:
        """Whether it runs several vehicles. Then their messages go in bundles, on its own keys."""
        return len(self.vehicles) > 1


def vehicle_processes(
    size: int, per_process: int, without: Collection[int] = ()
) -> tuple[VehicleProcess, ...]:
    """Return the processes of the vehicles 1 to `size`, each with `per_process` neighbours.

    Vehicles in `without` are left out. A vehicle whose neighbours are all left out has a process of
    its own, with the name that it has by default.
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
