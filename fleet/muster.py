"""Who has come to a run that waits for other machines, and who is missing."""

from __future__ import annotations

from collections.abc import Sequence

from zenvoy.bus.vehicle_processes import VehicleProcess
from zenvoy.fleet.progress import Arrival


class Muster:
    """Keeps the processes that have come, and the machine of each."""

    def __init__(self, processes: Sequence[VehicleProcess]) -> None:
        self._vehicles = {process.name: process.vehicles for process in processes}
        self._here: set[str] = set()
        self._hosts: dict[str, str] = {}

    def note(self, arrival: Arrival) -> bool:
        """Note that a process has come or gone; return whether that changes who is missing."""
        name, host, there = arrival
        if host:
            self._hosts[name] = host
        if name not in self._vehicles or host:
            return False
        before = len(self._here)
        (self._here.add if there else self._here.discard)(name)
        return len(self._here) != before

    @property
    def missing(self) -> list[int]:
        """The vehicles whose processes have not come, ascending."""
        absent = (ids for name, ids in self._vehicles.items() if name not in self._here)
        return sorted(vehicle for ids in absent for vehicle in ids)

    def host_of(self, process: str) -> str:
        """Return the machine on which a process runs, or "" if that is unknown."""
        return self._hosts.get(process.partition(" ")[0], "")

    @property
    def by_host(self) -> dict[str, list[int]]:
        """The vehicles that are here, by machine."""
        found: dict[str, list[int]] = {}
        for name in sorted(self._here, key=lambda one: self._vehicles[one]):
            found.setdefault(self._hosts.get(name, ""), []).extend(self._vehicles[name])
        return found
