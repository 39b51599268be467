"""Checks of the initial gaps and speeds of vehicles, if they are given one by one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from zenvoy.scenarios.errors import Problem
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.fleet import Fleet
    from zenvoy.scenarios.schema.scenario import Scenario


def start_that_disagrees(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for each list of the wrong length, and for each gap that is too small."""
    fleet = scenario.fleet
    yield from _counts(fleet)
    yield from _lengths(fleet)
    yield from _rest_of_ring(fleet, scenario.ring_length_m)


def _counts(fleet: Fleet) -> Iterator[Problem]:
    size = f"fleet.size ({fleet.size})"
    gaps_m, speeds_mps = fleet.initial_gaps_m, fleet.initial_speeds_mps
    if gaps_m is not None and len(gaps_m) != fleet.size - 1:
        text = f"{len(gaps_m)} numbers, not one less than {size}: the first vehicle has no gap"
        yield Problem(key="fleet.initial_gaps_m", text=text, related=("fleet.size",))
    if speeds_mps is not None and len(speeds_mps) != fleet.size:
        text = f"{len(speeds_mps)} numbers, not one for each of {size}"
        yield Problem(key="fleet.initial_speeds_mps", text=text, related=("fleet.size",))


def _lengths(fleet: Fleet) -> Iterator[Problem]:
    """Check that gaps, which are from front to front, exceed the length of a vehicle."""
    for index, gap_m in enumerate(fleet.initial_gaps_m or ()):
        if gap_m <= fleet.length_m:
            length = f"fleet.length_m ({trimmed(fleet.length_m)})"
            text = f"{trimmed(gap_m)} is not greater than {length}"
            key = f"fleet.initial_gaps_m.{index}"
            yield Problem(key=key, text=text, related=("fleet.length_m",))


def _rest_of_ring(fleet: Fleet, ring_m: float | None) -> Iterator[Problem]:
    """Check that the gaps on a ring leave a gap for the first vehicle."""
    if fleet.initial_gaps_m is None or ring_m is None:
        return
    left_m = ring_m - sum(fleet.initial_gaps_m)
    if left_m <= fleet.length_m:
        text = f"they leave {trimmed(round(left_m, 6))} m of the ring ({trimmed(ring_m)} m) to the "
        text += f"first vehicle, not more than fleet.length_m ({trimmed(fleet.length_m)})"
        related = ("fleet.gap_m", "fleet.size", "fleet.length_m", "road.type")
        yield Problem(key="fleet.initial_gaps_m", text=text, related=related)
