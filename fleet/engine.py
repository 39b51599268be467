"""The engines that can run a scenario."""

from __future__ import annotations

from typing import Final, Literal, get_args

Engine = Literal["processes", "in-process", "arrays"]
"""A process per vehicle on Zenoh; the whole fleet in this process; or the fleet as arrays.

All of them write the same log.
"""

Choice = Literal["processes", "in-process", "arrays", "auto"]
"""An engine, or "auto": arrays where they run the scenario, else in-process."""

ENGINES: Final[tuple[Engine, ...]] = get_args(Engine)
CHOICES: Final[tuple[Choice, ...]] = get_args(Choice)
