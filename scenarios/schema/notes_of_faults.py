"""Notes on faults that never happen."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from zenvoy.scenarios.errors import Problem
from zenvoy.values.section import NS_PER_S
from zenvoy.values.wording import trimmed

if TYPE_CHECKING:
    from zenvoy.scenarios.schema.scenario import Scenario


def notes_of_faults(scenario: Scenario) -> Iterator[Problem]:
    """Yield the notes on the faults of a valid scenario, without places."""
    end_ns = scenario.cycles * scenario.period_ns
    for index, fault in enumerate(scenario.faults):
        if fault.start_ns >= end_ns:
            start, end = (trimmed(round(t / NS_PER_S, 9)) for t in (fault.start_ns, end_ns))
            text = f"begins at {start} s, but the run ends at {end} s"
            key = f"faults.{index}"
            yield Problem(key=f"{key}.at_s", text=text, related=(key, "duration_s"))
