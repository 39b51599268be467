"""Faults of sensors: what they make of the readings of a cycle."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from zenvoy.keyed_random.draws import Purpose, numbered, uniforms
from zenvoy.scenarios import (
    READINGS,
    Fault,
    Scenario,
    SensorBiased,
    SensorBlind,
    SensorDrifting,
    SensorFrozen,
    SensorJumping,
    all_faults,
    reading_of,
)
from zenvoy.world.sensors import Readings

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Values = dict[str, Floats]


class _Now(NamedTuple):
    """A cycle, and the time at which it starts, ns."""

    cycle: int
    time_ns: int


class _Effect(Protocol):
    """Changes readings (n,), by name, in place."""

    def __call__(self, values: Values, now: _Now) -> None: ...


class SensorFaults:
    """The faults of a scenario's sensors, in the order of the scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self._effects = list(_effects(scenario))

    def read(
        self, readings: Readings, acceleration: Floats, cycle: int, now_ns: int
    ) -> tuple[Readings, Floats]:
        """Return readings and own accelerations (m/s²) of a cycle as faulty sensors give them."""
        current = [effect for fault, effect in self._effects if fault.in_force(now_ns)]
        if not current:
            return readings, acceleration
        values = {name: value.copy() for name, value in readings._asdict().items()}
        values["acceleration"] = acceleration.copy()
        for effect in current:
            effect(values, _Now(cycle, now_ns))
        acceleration = values.pop("acceleration")
        return Readings(**values), acceleration


def _effects(scenario: Scenario) -> Iterator[tuple[Fault, _Effect]]:
    for number, fault, vehicles in all_faults(scenario):
        index = np.array(vehicles, np.int64) - 1
        match fault:
            case SensorBlind():
                yield fault, _Blind(READINGS[fault.sensor], index)
            case SensorFrozen():
                yield fault, _Frozen(READINGS[fault.sensor], index)
            case SensorBiased():
                yield fault, _Biased(_by_reading(fault.amounts), index)
            case SensorDrifting():
                yield fault, _Drifting(_by_reading(fault.amounts), fault.start_ns, index)
            case SensorJumping():
                yield fault, _Jumping(fault, index, scenario.seed, number)
            case _:
                pass  # a fault of something else


def _by_reading(amounts: dict[str, float]) -> dict[str, float]:
    return {reading_of(key): value for key, value in amounts.items()}


class _Blind:
    """Reads nothing, which is NaN."""

    def __init__(self, names: tuple[str, ...], index: Ints) -> None:
        self._names, self._index = names, index

    def __call__(self, values: Values, now: _Now) -> None:
        for name in self._names:
            values[name][self._index] = np.nan


class _Frozen:
    """Keeps the readings of the first cycle in which the fault is in force."""

    def __init__(self, names: tuple[str, ...], index: Ints) -> None:
        self._names, self._index = names, index
        self._kept: Values | None = None

    def __call__(self, values: Values, now: _Now) -> None:
        if self._kept is None:
            self._kept = {name: values[name][self._index] for name in self._names}
        for name, kept in self._kept.items():
            values[name][self._index] = kept


class _Biased:
    """Adds constant amounts."""

    def __init__(self, amounts: dict[str, float], index: Ints) -> None:
        self._amounts, self._index = amounts, index

    def __call__(self, values: Values, now: _Now) -> None:
        for name, amount in self._amounts.items():
            values[name][self._index] += amount


class _Drifting:
    """Adds amounts at constant rates."""

    def __init__(self, rates: dict[str, float], start_ns: int, index: Ints) -> None:
        self._rates, self._start_ns, self._index = rates, start_ns, index

    def __call__(self, values: Values, now: _Now) -> None:
        for name, rate in self._rates.items():
            values[name][self._index] += rate * ((now.time_ns - self._start_ns) * 1e-9)


class _Jumping:
    """Draws whether readings jump, by fault, vehicle and cycle, and in which direction."""

    def __init__(self, fault: SensorJumping, index: Ints, seed: int, number: int) -> None:
        self._share, self._amounts = fault.share, _by_reading(fault.amounts)
        self._index, self._seed = index, seed
        self._purpose = numbered(Purpose.FAULT, number)

    def __call__(self, values: Values, now: _Now) -> None:
        vehicles = self._index + 1
        jumps = uniforms(self._seed, self._purpose, vehicles, 0, now.cycle)[0] < self._share
        for place, (name, amount) in enumerate(self._amounts.items(), start=1):
            up = uniforms(self._seed, self._purpose, vehicles, place, now.cycle)[0] < 0.5
            values[name][self._index] += np.where(jumps, np.where(up, amount, -amount), 0.0)
