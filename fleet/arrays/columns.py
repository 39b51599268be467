"""The columns of a log's tables in a cycle of a batch, by topic and name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from zenvoy.bus.topics import ESTIMATE, FLEET_COMMAND, RADAR, TRUTH
from zenvoy.fleet.arrays.batch import Cycle
from zenvoy.laws import law_of
from zenvoy.scenarios import Scenario, modes, roster
from zenvoy.vehicles.arrays.decisions import Decisions
from zenvoy.vehicles.arrays.estimates import ESTIMATES, NEIGHBOURS, OF_WHOLE, Array
from zenvoy.vehicles.arrays.vehicles import Senses

Column = Callable[[Cycle], Array]
"""A function that returns a column for all vehicles of a batch, (runs · n,), in a cycle."""

_TRUTH: Final[dict[str, Column]] = {
    "position": lambda cycle: cycle.position,
    "speed": lambda cycle: cycle.speed,
    "acceleration": lambda cycle: cycle.acceleration,
}


def columns_of(scenario: Scenario) -> dict[str, dict[str, Column]]:
    """Return the columns of a run's log, except cycle and time."""
    return {
        TRUTH.log_name: dict(_TRUTH),
        RADAR.log_name: {name: partial(_sensed, name) for name in Senses._fields},
        ESTIMATE.log_name: {**estimate_columns(scenario), **dict(logged_columns(scenario))},
        FLEET_COMMAND.log_name: {
            "acceleration": _commanded,
            "effective_ns": partial(_effective_ns, scenario),
        },
    }


def estimate_columns(scenario: Scenario) -> dict[str, Column]:
    """Return the columns of /fleet/estimate, except the values that laws log."""
    names = list(ESTIMATES)
    if any(law_of(model).needs.sides for one in roster(scenario) for model in one.models):
        names.append(NEIGHBOURS)
    return {name: partial(_estimated, name) for name in names}


def logged_columns(scenario: Scenario) -> list[tuple[str, Column]]:
    """Return name and column of each value that laws log, in their order: `Smith.desired_gap`."""
    return [
        (f"{law_of(model).name}.{column.name}", partial(_logged, mode, index))
        for model, mode in sorted(modes(scenario).items(), key=lambda one: one[1])
        for index, column in enumerate(law_of(model).columns)
    ]


def needs_whole(topic: str, name: str) -> bool:
    """Return whether only a `whole` batch has a column for every vehicle."""
    return topic == ESTIMATE.log_name and name in OF_WHOLE


def _sensed(name: str, cycle: Cycle) -> Array:
    values: Array = getattr(cycle.senses, name)
    return values


def _estimated(name: str, cycle: Cycle) -> Array:
    assert cycle.estimates is not None
    return cycle.estimates[name]


def _commanded(cycle: Cycle) -> Array:
    return _decisions(cycle).acceleration


def _effective_ns(scenario: Scenario, cycle: Cycle) -> Array:
    decided_ns = cycle.number * scenario.period_ns + scenario.v2v_wait_ns
    return np.full(len(cycle.position), decided_ns + scenario.system_delay_ns)


def _logged(number: int, index: int, cycle: Cycle) -> Array:
    mode, logged = _decisions(cycle).mode, _decisions(cycle).logged
    values = logged.get(number)
    if values is None:
        return np.full(len(mode), np.nan)
    return np.where(mode == number, values[index], np.nan)


def _decisions(cycle: Cycle) -> Decisions:
    assert cycle.decisions is not None
    return cycle.decisions
