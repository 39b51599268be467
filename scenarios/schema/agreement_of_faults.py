"""Checks of faults: a fault that changes values changes at least one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.schema.fault import Amounts

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario


def faults_that_disagree(scenario: Scenario) -> Iterator[Problem]:
    """Yield every disagreement of faults, without places."""
    for index, fault in enumerate(scenario.faults):
        if isinstance(fault, Amounts) and not fault.amounts:
            yield _changes_nothing(f"faults.{index}", fault)


def _changes_nothing(key: str, fault: Amounts) -> Problem:
    names = fault.keys_of_amounts
    text = f"changes nothing; allowed: {' or '.join(names)} other than 0"
    return Problem(key=key, text=text, related=tuple(f"{key}.{name}" for name in names))
