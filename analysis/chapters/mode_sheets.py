"""Tables of the modes of a ring, measured and by theory."""

from __future__ import annotations

import math

from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.analysis.theory.ring_modes import Modes

Row = tuple[Cell, ...]


def slowest(modes: Modes) -> list[Row]:
    """Return the figures of the mode that decays most slowly; none if no mode is known."""
    row = modes.slowest
    if row is None:
        return []
    both = (row.measured, row.theory)
    return [
        (
            f"slowest mode ({row.number}), growth rate",
            "1/s",
            *(found.rate if found else None for found in both),
        ),
        (
            f"slowest mode ({row.number}), frequency",
            "rad/s",
            *(found.omega if found else None for found in both),
        ),
        (
            f"slowest mode ({row.number}), half-life",
            "s",
            *(_half_life(found.rate) if found else None for found in both),
        ),
    ]


def _half_life(rate: float) -> float | None:
    return math.log(2.0) / -rate if rate < 0.0 else None


def mode_sheet(modes: Modes) -> Sheet:
    """Return a row per mode of the ring."""
    rows: list[Row] = []
    for row in modes.rows:
        measured, theory = row.measured, row.theory
        rows.append(
            (
                row.number,
                measured.rate if measured else None,
                theory.rate if theory else None,
                measured.omega if measured else None,
                theory.omega if theory else None,
                measured.r2 if measured else None,
            )
        )
    return Sheet(
        name="stability-modes",
        title="Modes of the ring",
        columns=(
            "mode",
            "growth rate, 1/s",
            "growth rate, theory, 1/s",
            "frequency, rad/s",
            "frequency, theory, rad/s",
            "R² of the fit",
        ),
        rows=tuple(rows),
        note="Mode n has n waves round the ring. A negative growth rate is a decay. A mode is "
        "measured if it is clearly stronger than before the disturbance, and if two exponents "
        "describe it, or three if actuators have a lag.",
    )
