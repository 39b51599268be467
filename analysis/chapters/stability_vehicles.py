"""The table of vehicles that a disturbance reaches: gains and dips, measured beside theory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from zenvoy.analysis.measures.stability import Norms
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.analysis.theory.disturbed import Disturbed

Floats = NDArray[np.float64]
Row = tuple[Cell, ...]


def vehicle_sheet(case: Disturbed) -> Sheet:
    """A row per vehicle that the disturbance reaches, from the front to the back."""
    backwards = _vehicle_rows(case, case.behind, 1)
    forwards = _vehicle_rows(case, case.ahead, -1)[1:]
    return Sheet(
        name="stability-vehicles",
        title="Away from the disturbed vehicle",
        columns=(
            "vehicle",
            "behind",
            "L2 gain",
            "L2 gain, theory",
            "L2 gain, last step",
            "L∞ gain",
            "L∞ gain, theory",
            "L∞ gain, last step",
            "lowest at, s",
            "lowest at, theory, s",
        ),
        rows=(*reversed(forwards), *backwards),
        note=_note(case),
    )


def _note(case: Disturbed) -> str:
    base = "that before" if case.from_start else "its mean"
    when = "" if case.predicted is None else ", over the time in which theory expects 99 % of them"
    dip = " Lowest: when the dip of speed of the braking was there." if case.has_dip else ""
    return (
        f"Norms of the deviation of speed from {base}, over those of the disturbed vehicle{when}. "
        "Last step: over those of the next vehicle on the way to it, where that one's stand out of "
        f"the noise.{dip}"
    )


def _vehicle_rows(case: Disturbed, order: NDArray[np.int64], sign: int) -> list[Row]:
    times = _dip_times(case, case.deviation, order)
    expected = _dip_times(case, case.predicted, order)
    seen, both = case.seen, gains_beside(case)
    rows = []
    for k, index in enumerate(order):
        row: list[Cell] = [int(index) + 1, sign * k]
        before = order[k - 1]
        for field in ("l2", "linf"):
            gain = getattr(both[0], field)
            step = float(gain[index] / gain[before]) if k and seen[before] else None
            row += [*pair([float(getattr(gains, field)[index]) for gains in both]), step]
        rows.append((*row, times[k], expected[k]))
    return rows


def _dip_times(
    case: Disturbed, deviation: Floats | None, order: NDArray[np.int64]
) -> list[float | None]:
    if deviation is None or not case.has_dip:
        return [None] * len(order)
    found = case.dips(deviation, order)
    times: dict[int, float] = dict(zip(found.behind.tolist(), found.time_s.tolist(), strict=True))
    return [times.get(k) for k in range(len(order))]


def gains_beside(case: Disturbed) -> list[Norms]:
    """Gains measured, and by theory where it says something."""
    known = (values for values in (case.deviation, case.predicted) if values is not None)
    return [case.gains(values) for values in known]


def pair(values: Sequence[float | None]) -> tuple[float | None, float | None]:
    """What was measured and what theory says, None where it is silent."""
    return values[0], values[1] if len(values) > 1 else None
