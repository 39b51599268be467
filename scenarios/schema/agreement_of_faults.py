"""Checks of faults: amounts that change something, and processes that fail one way at a time."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.fault import Amounts
from zenvoy.scenarios.schema.faults import all_faults
from zenvoy.scenarios.schema.faults_of_processes import ProcessFrozen, ProcessKilled
from zenvoy.scenarios.schema.faults_of_transmitters import TransmitterBabbling
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario


def faults_that_disagree(scenario: Scenario) -> Iterator[Problem]:
    """Yield every disagreement of faults, without places."""
    for index, fault in enumerate(scenario.faults):
        key = f"faults.{index}"
        if isinstance(fault, Amounts) and not fault.amounts:
            yield _changes_nothing(key, fault)
        if isinstance(fault, TransmitterBabbling) and scenario.channel.medium.access != "csma":
            related = ("channel.medium.access",)
            text = f"{fault.type} needs channel.medium.access: csma; else no frame disturbs another"
            yield Problem(key=f"{key}.type", text=text, related=related)
        if isinstance(fault, ProcessKilled):
            yield from _ends(fault, key, scenario)
    yield from _overlaps(scenario)


def _changes_nothing(key: str, fault: Amounts) -> Problem:
    names = fault.keys_of_amounts
    text = f"changes nothing; allowed: {' or '.join(names)} other than 0"
    return Problem(key=key, text=text, related=tuple(f"{key}.{name}" for name in names))


def _ends(fault: ProcessKilled, key: str, scenario: Scenario) -> Iterator[Problem]:
    """Check that a killed vehicle comes back if and only if vehicles are restarted."""
    loss, related = scenario.on_vehicle_loss, ("on_vehicle_loss", key)
    if fault.start_ns == 0:
        text = "0 is before the first cycle, so there is no process yet; allowed: later"
        yield Problem(key=f"{key}.at_s", text=text)
    if loss == "restart" and fault.duration_s is None:
        text = "missing; on_vehicle_loss is restart, which needs it"
        yield Problem(key=f"{key}.duration_s", text=text, related=related)
    if loss != "restart" and fault.duration_s is not None:
        given = trimmed(fault.duration_s)
        text = f"{given} is given, but on_vehicle_loss is {loss}, so no process comes back"
        yield Problem(key=f"{key}.duration_s", text=f"{text}; allowed: null", related=related)


def _overlaps(scenario: Scenario) -> Iterator[Problem]:
    """Check that no process is killed or frozen while it is killed or frozen."""
    spans: dict[int, list[tuple[int, int, int]]] = {}  # begin, index, end by vehicle
    try:
        for index, fault, vehicles in all_faults(scenario):
            if isinstance(fault, ProcessKilled | ProcessFrozen):
                for vehicle in vehicles:
                    spans.setdefault(vehicle, []).append((fault.start_ns, index, fault.end_ns))
    except ValueError:
        return  # a set of vehicles is wrong, which has an error of its own
    found = set()
    for of_vehicle in spans.values():
        for (_, index, end_ns), (start_ns, other, _) in pairwise(sorted(of_vehicle)):
            if start_ns <= end_ns:
                found.add((other, index))
    for other, index in sorted(found):
        text = f"begins while faults.{index} has the same vehicle; allowed: one after the other"
        keys = (f"faults.{other}", f"faults.{index}")
        related = tuple(f"{key}.{part}" for key in keys for part in ("at_s", "duration_s"))
        yield Problem(key=f"faults.{other}", text=text, related=related)
