"""The settings of each vehicle, from the fleet, its groups and the schedule."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from zenvoy.scenarios.schema.control_laws import name_of
from zenvoy.scenarios.schema.courses import Targets, course
from zenvoy.scenarios.schema.sets import drawn, members

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.control import Control, Switch
    from zenvoy.scenarios.schema.fleet import Fleet, Gains, Group, Vehicle
    from zenvoy.scenarios.schema.scenario import Scenario

_NS_PER_S = 1_000_000_000

# An entry of the schedule, and its vehicles; None: all vehicles whose groups do not set the value
# that it changes.
Entry = tuple["Switch", frozenset[int] | None]
_GAINS = ("k_d", "k_v", "k_c")


class Phase(NamedTuple):
    """The time (ns) from which a model is in force, the model, and the parameters of its law."""

    from_ns: int
    model: str
    parameters: tuple[tuple[str, Any], ...] = ()


class Limits(NamedTuple):
    """The lowest and the highest acceleration of a vehicle, m/s²."""

    lowest: float
    highest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """The settings of one vehicle.

    phases has its laws in order of time. Gains, desired gap and desired speed are those at the
    start; `targets` has them over time. lag_s: time constant of its actuator, s; 0: no lag.
    """

    phases: tuple[Phase, ...]
    gains: Gains
    desired_gap_m: float
    desired_speed_mps: float
    limits: Limits
    lag_s: float
    beacons: bool
    targets: Targets

    @property
    def program(self) -> tuple[tuple[int, str], ...]:
        """The time (ns) from which each model is in force, and its name in messages."""
        return tuple((phase.from_ns, name_of(phase.model)) for phase in self.phases)

    @property
    def models(self) -> frozenset[str]:
        """All models that the vehicle runs."""
        return frozenset(phase.model for phase in self.phases)


def roster(scenario: Scenario) -> tuple[Settings, ...]:
    """Return the settings of vehicles 1..size, in order; the scenario must be valid.

    Scenarios that differ only in a seed that draws no group share one result.
    """
    sets = tuple(group_members(scenario).items())
    return _roster(scenario.control, scenario.fleet, scenario.vehicle, sets)


@lru_cache(maxsize=32)
def _roster(
    control: Control, fleet: Fleet, vehicle: Vehicle, sets: tuple[tuple[str, frozenset[int]], ...]
) -> tuple[Settings, ...]:
    by_name = dict(sets)
    texts = {switch.vehicles for switch in control.schedule}
    named = {text: members(text, fleet.size, by_name) for text in texts if text is not None}
    entries: list[Entry] = [
        (switch, None if switch.vehicles is None else named[switch.vehicles])
        for switch in control.schedule
    ]
    numbers = range(1, fleet.size + 1)
    return tuple(
        _settings(control, _groups(fleet, number, by_name), vehicle, number, entries)
        for number in numbers
    )


def _groups(fleet: Fleet, number: int, sets: Mapping[str, frozenset[int]]) -> list[Group]:
    """Return the groups of a vehicle; later ones come first, as they override earlier ones."""
    return [group for group in reversed(fleet.groups) if number in sets[group.name]]


def group_members(scenario: Scenario) -> dict[str, frozenset[int]]:
    """Return the vehicles of each group; raises ValueError if a set is not valid."""
    size = scenario.fleet.size
    sets: dict[str, frozenset[int]] = {}
    for group in scenario.fleet.groups:
        if group.vehicles is not None:
            sets[group.name] = members(group.vehicles, size, sets)
        else:
            sets[group.name] = drawn(group.name, group.share or 0.0, size, scenario.seed)
    return sets


def _settings(
    control: Control, mine: list[Group], fleet_vehicle: Vehicle, vehicle: int, entries: list[Entry]
) -> Settings:
    own_model = next((g for g in mine if g.model is not None), None)
    own_gains = next((g.gains for g in mine if g.gains is not None), None)
    gap_m = next((g.desired_gap_m for g in mine if g.desired_gap_m is not None), None)
    speed_mps = next((g.desired_speed_mps for g in mine if g.desired_speed_mps is not None), None)
    gains = control.gains if own_gains is None else own_gains
    start = {
        "desired_gap_m": control.desired_gap_m if gap_m is None else gap_m,
        "desired_speed_mps": control.desired_speed_mps if speed_mps is None else speed_mps,
        **{name: getattr(gains, name) for name in _GAINS},
    }
    of_groups = {
        *(["model"] if own_model is not None else []),
        *(["desired_gap_m"] if gap_m is not None else []),
        *(["desired_speed_mps"] if speed_mps is not None else []),
        *(_GAINS if own_gains is not None else []),
    }
    first = control if own_model is None else own_model
    phases = [Phase(0, first.model or control.model, first.parameters)]
    phases += [
        Phase(round(switch.at_s * _NS_PER_S), switch.model, switch.parameters)
        for switch, whom in entries
        if switch.model is not None and _concerns(vehicle, whom, "model", of_groups)
    ]
    own_vehicle = [fleet_vehicle, *(g.vehicle for g in reversed(mine) if g.vehicle is not None)]
    return Settings(
        phases=tuple(phases),
        gains=gains,
        desired_gap_m=start["desired_gap_m"],
        desired_speed_mps=start["desired_speed_mps"],
        limits=_limits(control.acceleration_limit_mps2, own_vehicle),
        lag_s=_last_given([one.actuator_lag_s for one in own_vehicle], 0.0),
        beacons=all(g.beacons for g in mine),
        targets=_targets(vehicle, start, entries, of_groups),
    )


def _limits(limit: float, given: Sequence[Vehicle]) -> Limits:
    return Limits(
        -_last_given([one.max_deceleration_mps2 for one in given], limit),
        _last_given([one.max_acceleration_mps2 for one in given], limit),
    )


def _last_given(values: Sequence[float | None], otherwise: float) -> float:
    return next((value for value in reversed(values) if value is not None), otherwise)


def _concerns(
    vehicle: int, whom: frozenset[int] | None, name: str, of_groups: Container[str]
) -> bool:
    return name not in of_groups if whom is None else vehicle in whom


def _targets(
    vehicle: int, start: Mapping[str, float], entries: list[Entry], of_groups: Container[str]
) -> Targets:
    changes: dict[str, list[tuple[int, int, float]]] = {name: [] for name in start}
    for switch, whom in entries:
        at_ns, ramp_ns = round(switch.at_s * _NS_PER_S), round(switch.ramp_s * _NS_PER_S)
        for name, value in switch.targets.items():
            if _concerns(vehicle, whom, name, of_groups):
                changes[name].append((at_ns, ramp_ns, value))
    speeds = changes["desired_speed_mps"]
    return Targets(
        **{name: course(value, changes[name]) for name, value in start.items()},
        cruises_ns=speeds[0][0] if speeds else None,
    )
