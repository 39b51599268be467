"""The chapter on estimation: how the filters improve on readings (paper Fig. k_1 to k_4, Tab. 6).

A filter is judged in two ways: by how much closer its estimates are to the truth than the readings,
and by whether its errors are as large as it claims.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from zenvoy.analysis.chapters.estimation_pictures import (
    draw_against_truth,
    draw_consistency,
    draw_errors,
)
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.agreement import Agreement, agreement
from zenvoy.analysis.measures.consistency import (
    Consistency,
    consistency,
    normalised_error,
    normalised_innovation,
    spread,
)
from zenvoy.analysis.measures.metrics import meaningful_r2
from zenvoy.analysis.measures.quantities import Quantity, first_disturbed, quantities
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet

_TITLE: Final = "Estimation"
_AGREEMENT_NOTE: Final = (
    "RMSE and the spread (standard deviation) of the truth are in the unit of the quantity. R² is "
    "1 - SS_res / SS_tot. It is left out where it would be below 0, because the error exceeds the "
    "spread of the truth. R² (correlation) is the square of Pearson's correlation coefficient. "
    "Both rows of a quantity use the same instants: those that have an estimate."
)
_CONSISTENCY_NOTE: Final = (
    "Normal errors are within 1, 2 and 3 σ in 68.3, 95.4 and 99.7 % of all cases. NEES is the "
    "squared error divided by the variance that the filter claims; NIS is the same for the "
    "innovation, as far as the log allows. The mean of both is 1 for a consistent filter, and less "
    'for one that is too cautious. "Inside" is the share of cycles in which the mean over the '
    "fleet is within the 95 % interval of χ². Reading errors are uniform by default, so NIS "
    "scatters less than χ² predicts; its mean is unaffected."
)


def estimation_section(run: Run) -> Section:
    """Return the agreement of readings and estimates with the truth, and filter consistency."""
    if not run.cycles:
        return Section(
            title=_TITLE, notes=("No cycle was logged, so there is nothing to compare.",)
        )
    found = quantities(run)
    if all(np.isnan(quantity.estimated).all() for quantity in found):
        note = "No filter ran: the models of this run act on readings directly."
        return Section(title=_TITLE, notes=(note,))
    vehicle = _shown(run, found)
    return Section(
        title=_TITLE,
        sheets=(
            agreement_sheet(found[:3], None),
            agreement_sheet(found[:3], vehicle),
            consistency_sheet(found),
        ),
        pictures=_pictures(run, found, vehicle),
        notes=_notes(run, found),
    )


def _shown(run: Run, found: Sequence[Quantity]) -> int:
    """Return the first disturbed vehicle, or the next one behind it with the most estimates.

    Some vehicles may run laws that estimate nothing.
    """
    first = first_disturbed(run)
    order = [(first - 1 + k) % run.vehicles for k in range(run.vehicles)]
    known = [
        sum(not np.isnan(quantity.estimated[:, v]).all() for quantity in found[:3]) for v in order
    ]
    return order[known.index(max(known))] + 1


def agreement_sheet(found: Sequence[Quantity], vehicle: int | None) -> Sheet:
    """Return RMSE and both R² of readings and estimates, for one vehicle or (None) for all."""
    rows: list[tuple[Cell, ...]] = []
    of = slice(None) if vehicle is None else slice(vehicle - 1, vehicle)
    for quantity in found:
        true, estimated = quantity.true[:, of], quantity.estimated[:, of]
        measured = np.where(np.isnan(estimated), np.nan, quantity.measured[:, of])
        for kind, values in (("measured", measured), ("estimated", estimated)):
            rows.append((quantity.label, kind, *_cells(agreement(values, true))))
    who = "all vehicles" if vehicle is None else f"vehicle {vehicle}"
    return Sheet(
        name="estimation-fleet" if vehicle is None else "estimation-vehicle",
        title=f"Agreement with the truth, {who}",
        columns=(
            "quantity",
            "values",
            "samples",
            "RMSE",
            "spread of the truth",
            "R²",
            "R² (correlation)",
        ),
        rows=tuple(rows),
        note=_AGREEMENT_NOTE,
    )


def consistency_sheet(found: Sequence[Quantity]) -> Sheet:
    """Compare errors with the variances that the filters claim."""
    rows: list[tuple[Cell, ...]] = []
    for quantity in found:
        within = spread(quantity.error, quantity.std)
        shares = (None,) * 3 if within is None else tuple(100.0 * share for share in within)
        nees, nis = consistency(nees_of(quantity)), consistency(nis_of(quantity))
        rows.append((quantity.label, *shares, *_judged(nees), *_judged(nis)))
    return Sheet(
        name="estimation-consistency",
        title="Consistency of the filters, all vehicles",
        columns=(
            "quantity",
            "within 1 σ, %",
            "within 2 σ, %",
            "within 3 σ, %",
            "mean NEES",
            "NEES inside, % of cycles",
            "mean NIS",
            "NIS inside, % of cycles",
        ),
        rows=tuple(rows),
        note=_CONSISTENCY_NOTE,
    )


def nees_of(quantity: Quantity) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the normalised squared errors of the estimates, (cycles, vehicles)."""
    return normalised_error(quantity.error, quantity.std)


def nis_of(quantity: Quantity) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the normalised squared innovations, (cycles, vehicles), from `normalised_innovation`.

    They are all NaN where the filter's input is not the reading in the log.
    """
    if not quantity.filters_reading:
        return np.full(quantity.true.shape, np.nan)
    return normalised_innovation(
        quantity.measured, quantity.estimated, quantity.std, quantity.reading_variance
    )


def _pictures(run: Run, found: tuple[Quantity, ...], vehicle: int) -> tuple[Picture, ...]:
    return (
        Picture(
            name="estimation-truth",
            caption=(
                f"Own speed and gap ahead of vehicle {vehicle} around the first disturbance, or "
                "from the start of a run without one. The left panels show measurements, the right "
                "panels show estimates, each with the truth. RMSE and R² are for the whole run."
            ),
            draw=lambda: draw_against_truth(run, found, vehicle),
        ),
        Picture(
            name="estimation-error",
            caption=(
                f"Error of the estimates of vehicle {vehicle} over the run, with the ±3 σ band "
                "that its filters claim. The errors of a consistent filter leave the band in 0.3 % "
                "of all cycles."
            ),
            draw=lambda: draw_errors(run, found, vehicle),
        ),
        Picture(
            name="estimation-consistency",
            caption=(
                "Squared errors (NEES) and innovations (NIS) of the link ahead, divided by the "
                "variance that the filter claims: mean over the fleet in each cycle, with the 95 % "
                "interval of χ². Filters above the interval are overconfident, and filters below "
                "it too cautious."
            ),
            draw=lambda: draw_consistency(
                run,
                [(quantity, nees_of(quantity), nis_of(quantity)) for quantity in found[1:3]],
            ),
        ),
    )


def _notes(run: Run, found: Sequence[Quantity]) -> tuple[str, ...]:
    notes = []
    if run.scenario.sensors.error == 0.0:
        notes.append("The sensors have no error, so NIS is not defined, and NEES is near 0.")
    if not all(quantity.filters_reading for quantity in found):
        notes.append(
            "The filters use differences of reported positions instead of radar readings. "
            "The measured values below are still those of the radar, and links have no NIS."
        )
    without = int(np.isnan(found[0].estimated).all(axis=0).sum())
    if without:
        notes.append(f"{without} of {run.vehicles} vehicles run no filter and are left out.")
    return tuple(notes)


def _cells(found: Agreement | None) -> tuple[Cell, ...]:
    if found is None:
        return (0, None, None, None, None)
    r2 = meaningful_r2(found.r2)
    return (found.samples, found.rmse, found.spread, r2, _known(found.r2_correlation))


def _judged(found: Consistency | None) -> tuple[Cell, Cell]:
    return (None, None) if found is None else (found.mean, 100.0 * found.share_inside)


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
