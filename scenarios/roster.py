"""What a scenario tells each vehicle: groups and schedule, worked out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from zenvoy.scenarios.sets import drawn, members

if TYPE_CHECKING:
    from zenvoy.scenarios.schema import Gains, Model, Scenario

_NS_PER_S = 1_000_000_000

# A switch: when (ns), to what, and for whom; None: for all without a model from a group.
Phase = tuple[int, "Model", frozenset[int] | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Of one vehicle. phases: each model with the time (ns) from which it is in force."""

    phases: tuple[tuple[int, Model], ...]
    gains: Gains
    desired_gap_m: float
    desired_speed_mps: float
    beacons: bool

    @property
    def models(self) -> frozenset[Model]:
        """Every model it ever runs."""
        return frozenset(model for _, model in self.phases)


@lru_cache(maxsize=4)
def roster(scenario: Scenario) -> tuple[Settings, ...]:
    """Settings of vehicles 1..size, in order; the scenario must be a valid one."""
    sets = group_members(scenario)
    size = scenario.fleet.size
    switches: list[Phase] = [
        (
            round(switch.at_s * _NS_PER_S),
            switch.model,
            None if switch.vehicles is None else members(switch.vehicles, size, sets),
        )
        for switch in scenario.control.schedule
    ]
    return tuple(_settings(scenario, v, sets, switches) for v in range(1, size + 1))


def group_members(scenario: Scenario) -> dict[str, frozenset[int]]:
    """The vehicles of each group. Raises ValueError where a set cannot be understood."""
    size = scenario.fleet.size
    sets: dict[str, frozenset[int]] = {}
    for group in scenario.fleet.groups:
        if group.vehicles is not None:
            sets[group.name] = members(group.vehicles, size, sets)
        else:
            sets[group.name] = drawn(group.name, group.share or 0.0, size, scenario.seed)
    return sets


def _settings(
    scenario: Scenario,
    vehicle: int,
    sets: dict[str, frozenset[int]],
    switches: list[Phase],
) -> Settings:
    control = scenario.control
    # Later groups count, so each setting is the last that is given.
    mine = [g for g in reversed(scenario.fleet.groups) if vehicle in sets[g.name]]
    own_model = next((g.model for g in mine if g.model is not None), None)
    phases: list[tuple[int, Model]] = [(0, own_model or control.model)]
    phases += [
        (at_ns, model)
        for at_ns, model, whom in switches
        if (vehicle in whom if whom is not None else own_model is None)
    ]
    gap_m = next((g.desired_gap_m for g in mine if g.desired_gap_m is not None), None)
    speed_mps = next((g.desired_speed_mps for g in mine if g.desired_speed_mps is not None), None)
    return Settings(
        phases=tuple(phases),
        gains=next((g.gains for g in mine if g.gains is not None), control.gains),
        desired_gap_m=control.desired_gap_m if gap_m is None else gap_m,
        desired_speed_mps=control.desired_speed_mps if speed_mps is None else speed_mps,
        beacons=all(g.beacons for g in mine),
    )
