"""The tables that `python -m tests.parity` prints, and docs/validation.md shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from tests.parity.figures import compared, ratios_of_speeds, smallest_gaps, swings_of_gaps
from tests.parity.headways import limits_in_runs
from tests.parity.loops import LOOPS, limit_in_theory
from tests.parity.tables import table


def swings() -> list[str]:
    """Return the swings of the gaps behind a leader that oscillates."""
    return table(compared(swings_of_gaps, "sine"), digits=4)


def ratios() -> list[str]:
    """Return the ratios of speeds in the same runs."""
    return table(compared(ratios_of_speeds, "sine"), digits=4)


def braking() -> list[str]:
    """Return the smallest gaps behind a leader that brakes."""
    return table(compared(smallest_gaps, "braking"), digits=3)


def commands() -> list[str]:
    """Return the smallest gaps where the commands of followers are limited."""
    return table(compared(smallest_gaps, "braking", "commands"), digits=3)


def engines() -> list[str]:
    """Return the smallest gaps where in SUMO the engines of followers are limited."""
    return table(compared(smallest_gaps, "braking", "engines"), digits=3)


def headways() -> list[str]:
    """Return the smallest string-stable headways of Ploeg's loops."""
    lines = [
        "| loop | published | theory | runs | runs from theory, % |",
        "|---|---:|---:|---:|---:|",
    ]
    for loop, run in zip(LOOPS, limits_in_runs(), strict=True):
        theory = limit_in_theory(loop)
        off = 100.0 * (run / theory - 1.0)
        lines.append(
            f"| {loop.name} | {loop.published_s} | {theory:.4f} | {run:.4f} | {off:+.1f} |"
        )
    return lines


PARTS: Final[dict[str, Callable[[], list[str]]]] = {
    "sine": lambda: [*swings(), "", *ratios()],
    "braking": braking,
    "limits": lambda: [*commands(), "", *engines()],
    "headways": headways,
}
