"""Helpers make scenarios with faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from zenvoy.scenarios import Fleet, Scenario, Sensors


def scenario_with(faults: Sequence[dict[str, Any]], *, size: int = 6, **settings: Any) -> Scenario:
    """Return a scenario without sensor noise, and with these faults."""
    return Scenario.model_validate(
        {
            "fleet": Fleet(size=size).model_dump(),
            "sensors": Sensors(error=0.0).model_dump(),
            "faults": faults,
            **settings,
        }
    )
