"""The table of vehicles that a disturbance reaches: gains and dips, measured and by theory."""

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
    """Return a row per vehicle that the disturbance reaches, from front to back."""
    backwards = _vehicle_rows(case, case.backwards, 1)
    forwards = _vehicle_rows(case, case.forwards, -1)[1:]
    return Sheet(
        name="stability-vehicles",
        title="Vehicles that the disturbance reaches",
        columns=(
            "vehicle",
            "behind",
            "L2 gain",
            "L2 gain, theory",
            "L2 gain, last step",
            "L∞ gain",
            "L∞ gain, theory",
            "L∞ gain, last step",
            "dip at, s",
            "dip at, theory, s",
        ),
        rows=(*reversed(forwards), *backwards),
        note=_note(case),
    )


def _note(case: Disturbed) -> str:
    base = "the speed before" if case.from_start else "each vehicle's mean"
    when = " They cover the time in which theory expects 99 % of the response."
    when = "" if case.predicted is None else when
    dip = " The dip is the lowest speed as the braking passes." if case.has_dip else ""
    return (
        f"Gains are norms of the deviation from {base}, divided by that of the disturbed vehicle."
        f"{when} The last step is the gain from the vehicle before it on the way; it is left out "
        f"where that vehicle's deviation is not above the noise.{dip}"
    )


def _vehicle_rows(case: Disturbed, order: NDArray[np.int64], sign: int) -> list[Row]:
    times = _dip_times(case, case.deviation, order)
    expected = _dip_times(case, case.predicted, order)
    above_noise, both = case.above_noise, gains_beside(case)
    rows = []
    for k, index in enumerate(order):
        row: list[Cell] = [int(index) + 1, sign * k]
        before = order[k - 1]
        for field in ("l2", "linf"):
            gain = getattr(both[0], field)
            step = float(gain[index] / gain[before]) if k and above_noise[before] else None
            row += [*pair([float(getattr(gains, field)[index]) for gains in both]), step]
        rows.append((*row, times[k], expected[k]))
    return rows


def _dip_times(
    case: Disturbed, deviation: Floats | None, order: NDArray[np.int64]
) -> list[float | None]:
    if deviation is None or not case.has_dip:
        return [None] * len(order)
    found = case.dips(deviation, order)
    times: dict[int, float] = dict(zip(found.steps.tolist(), found.time_s.tolist(), strict=True))
    return [times.get(k) for k in range(len(order))]


def gains_beside(case: Disturbed) -> list[Norms]:
    """Return the measured gains, and those by theory if there is a prediction."""
    known = (values for values in (case.deviation, case.predicted) if values is not None)
    return [case.gains(values) for values in known]


def pair(values: Sequence[float | None]) -> tuple[float | None, float | None]:
    """Return the measured value and that of theory, which is None without a prediction."""
    return values[0], values[1] if len(values) > 1 else None
