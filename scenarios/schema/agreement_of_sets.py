"""Checks of sets of vehicles: groups, and the settings that name them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.sets import at_most
from zenvoy.values.wording import shown

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario

# Sets are stored member by member, so twice as many would take a gigabyte.
_MOST_MEMBERS: Final = 2_000_000
_RESERVED: Final = ("all", "not")


def sets_that_disagree(scenario: Scenario) -> Iterator[Problem]:
    """Yield a problem for every set that is not valid, or too large, without places."""
    sizes: dict[str, int] = {}
    yield from _groups(scenario, sizes)
    scopes = {
        f"channel.{kind}.{index}.{end}": getattr(scope, end)
        for kind in ("rules", "outages")
        for index, scope in enumerate(getattr(scenario.channel, kind))
        for end in ("source", "destination")
    }
    switches = {
        f"control.schedule.{index}.vehicles": switch.vehicles
        for index, switch in enumerate(scenario.control.schedule)
    }
    hit = {
        f"faults.{index}.vehicles": fault.vehicles for index, fault in enumerate(scenario.faults)
    }
    sections = (("channel", scopes), ("control.schedule", switches), ("faults", hit))
    for section, sets in sections:
        total = 0
        for key, text in sets.items():
            if text is not None:
                try:
                    total += at_most(text, scenario.fleet.size, sizes)
                except ValueError as error:
                    yield Problem(key=key, text=str(error), related=("fleet.size",))
        yield from _too_many(section, total)


def _groups(scenario: Scenario, sizes: dict[str, int]) -> Iterator[Problem]:
    """Check that names are new, and that sets name only vehicles and earlier groups.

    Fills `sizes`.
    """
    size, total = scenario.fleet.size, 0
    for index, group in enumerate(scenario.fleet.groups):
        key = f"fleet.groups.{index}"
        if group.name in _RESERVED:
            text = f"{group.name!r} has another meaning in a set of vehicles"
            yield Problem(key=f"{key}.name", text=text)
        elif group.name in sizes:
            text = f"{shown(group.name)} is already the name of another group"
            yield Problem(key=f"{key}.name", text=text)
        if (group.vehicles is None) == (group.share is None):
            given = "neither vehicles nor" if group.share is None else "both vehicles and"
            text = f"{given} share; allowed: one of the two"
            yield Problem(key=key, text=text, related=(f"{key}.vehicles", f"{key}.share"))
        count = size  # a share is drawn from all of them
        if group.vehicles is not None:
            try:
                count = at_most(group.vehicles, size, sizes)
            except ValueError as error:
                yield Problem(key=f"{key}.vehicles", text=str(error), related=("fleet.size",))
        if group.name not in _RESERVED:
            sizes[group.name] = count
        total += count
    yield from _too_many("fleet.groups", total)


def _too_many(key: str, total: int) -> Iterator[Problem]:
    if total > _MOST_MEMBERS:
        text = f"the sets have {total} members together, more than the limit of {_MOST_MEMBERS}"
        yield Problem(key=key, text=text, related=("fleet.size",))
