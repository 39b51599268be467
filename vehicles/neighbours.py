"""The neighbours that a vehicle uses, by the order in which vehicles drive."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from zenvoy.scenarios import Scenario
from zenvoy.vehicles.decision import Controller


@dataclass(frozen=True, slots=True, kw_only=True)
class Neighbours:
    """Vehicles ahead and behind, nearest first, and the leader of the platoon (0: none).

    `seam_ahead` and `seam_behind` are the lengths (m) to be added to the difference of reported
    positions: positions are not wrapped, so one ring length lies between vehicle 1 and vehicle n.
    """

    ahead: tuple[int, ...]
    behind: tuple[int, ...]
    seam_ahead: tuple[float, ...]
    seam_behind: tuple[float, ...]
    leader: int = 0

    @property
    def everyone(self) -> frozenset[int]:
        """All vehicles whose beacons are used."""
        return frozenset({*self.ahead, *self.behind, self.leader} - {0})


def neighbours(scenario: Scenario, vehicle: int, controllers: Iterable[Controller]) -> Neighbours:
    """Return the neighbours of `vehicle` that any of its controllers uses."""
    each = tuple(controllers)
    size, length_m = scenario.fleet.size, scenario.ring_length_m
    m = max(1, *(one.law.sides(one.parameters) for one in each))
    steps = range(1, m + 1)
    if length_m is None:
        ahead = [vehicle - j for j in steps if vehicle - j >= 1]
        behind = [vehicle + j for j in steps if vehicle + j <= size]
    else:
        ahead = [(vehicle - 1 - j) % size + 1 for j in steps]
        behind = [(vehicle - 1 + j) % size + 1 for j in steps]
    seam = length_m or 0.0
    return Neighbours(
        ahead=tuple(ahead),
        behind=tuple(behind),
        seam_ahead=tuple(seam if other > vehicle else 0.0 for other in ahead),
        seam_behind=tuple(seam if other < vehicle else 0.0 for other in behind),
        leader=_leader(scenario, vehicle) if any(one.law.needs.leader for one in each) else 0,
    )


def _leader(scenario: Scenario, vehicle: int) -> int:
    size = scenario.control.platoon.size or scenario.fleet.size
    return (vehicle - 1) // size * size + 1
