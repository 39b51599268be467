"""What drives the agents of a run."""

from __future__ import annotations

from typing import Final, Literal, get_args

Engine = Literal["processes", "in-process"]
"""A process per vehicle on Zenoh, or the whole fleet in this process. Both write the same log."""

ENGINES: Final[tuple[Engine, ...]] = get_args(Engine)
