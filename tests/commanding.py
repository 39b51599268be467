"""Gives commands to the fleet of a world."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from zenvoy.world.fleet import Fleet


def give(fleet: Fleet, commands: Iterable[tuple[int, int, float]]) -> None:
    """Let a fleet take in commands: vehicle, time of effect (ns) and acceleration (m/s²)."""
    table = np.array(list(commands), dtype=np.float64).reshape(-1, 3)
    fleet.command(table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2])
