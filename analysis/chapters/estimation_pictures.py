"""Pictures of the chapter on estimation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from zenvoy.analysis.log.load import Run
from zenvoy.analysis.measures.agreement import agreement
from zenvoy.analysis.measures.consistency import consistency
from zenvoy.analysis.measures.instants import around_first
from zenvoy.analysis.measures.metrics import meaningful_r2
from zenvoy.analysis.measures.quantities import Quantity
from zenvoy.analysis.measures.spacing import FRONTS, spacing_of
from zenvoy.analysis.page.happenings import happenings
from zenvoy.analysis.page.marks import mark
from zenvoy.analysis.page.style import (
    ESTIMATED,
    MEASURED,
    THEORY,
    TRUE,
    figure_legend,
    plain_log,
    subplots,
)

_WINDOW_S: Final = 60.0
_MAX_DOTS: Final = 1_500  # dots or corners; more are rasterised
_BEFORE_S: Final = 5.0  # part of the window that is before the first disturbance
# Thousands of dots or corners are rasterised, as shapes would make an SVG megabytes large.
_BAND: Final = {"color": THEORY, "alpha": 0.25, "lw": 0, "rasterized": True}
_DOTS: Final = {"color": ESTIMATED, "ms": 1.5, "alpha": 0.5, "rasterized": True}


def draw_against_truth(run: Run, found: Sequence[Quantity], vehicle: int) -> Figure:
    """Draw speed and gap of one vehicle, measured and estimated, around the first disturbance."""
    figure, axes = subplots(2, 2, height_in=4.4, sharex=True, sharey="row")
    shown = _window(run)
    column = vehicle - 1
    kinds = (("measured", MEASURED, "."), ("estimated", ESTIMATED, "-"))
    marked = happenings(run)
    for row, quantity in zip(axes, found[:2], strict=True):
        spacing = spacing_of(run.scenario) if quantity.unit == "m" else FRONTS
        true = spacing.shown(quantity.true[:, column])
        for axis, (kind, colour, line) in zip(row, kinds, strict=True):
            values = spacing.shown(getattr(quantity, kind)[:, column])
            axis.plot(
                run.time_s[shown],
                values[shown],
                line,
                color=colour,
                ms=3,
                label=kind,
                rasterized=shown.size > _MAX_DOTS,
            )
            axis.plot(run.time_s[shown], true[shown], color=TRUE, lw=1.0, label="true")
            axis.set_title(_title(kind, quantity, values, true))
        row[0].set_ylabel(spacing.named(quantity.name, quantity.unit))
    low, high = run.time_s[shown][[0, -1]]
    axes[0, 0].set_xlim(low, max(high, low + 1e-3))
    for axis in axes.flat:
        mark(axis, marked)
    for axis in axes[1]:
        axis.set_xlabel("time, s")
    figure_legend(figure, *axes[0], markerscale=3)
    return _typed(figure)


def draw_errors(run: Run, found: Sequence[Quantity], vehicle: int) -> Figure:
    """Draw the errors of one vehicle's estimates, with the band that its filters claim."""
    figure, axes = subplots(3, 1, height_in=5.2, sharex=True)
    time_s = run.time_s[: run.cycles]
    for axis, quantity in zip(axes, found[:3], strict=True):
        error, std = quantity.error[:, vehicle - 1], quantity.std[:, vehicle - 1]
        band = 3.0 * std
        axis.fill_between(time_s, -band, band, **_BAND, label="±3 σ claimed")
        axis.plot(time_s, error, color=ESTIMATED, lw=0.6, label="error of the estimate")
        if not np.isnan(error).all():
            limit = 1.6 * max(np.nanmedian(band), np.nanpercentile(np.abs(error), 99.5))
            axis.set_ylim(-limit, limit)  # cut the wide band of the first cycles, where P = R
        axis.set_ylabel(f"{quantity.name},\n{quantity.unit}")
    axes[-1].set_xlim(time_s[0], max(time_s[-1], time_s[0] + 1e-3))
    for axis in axes:
        mark(axis, happenings(run))
    figure_legend(figure, *axes)
    axes[-1].set_xlabel("time, s")
    figure.align_ylabels()
    return _typed(figure)


def draw_consistency(
    run: Run, judged: Sequence[tuple[Quantity, NDArray[Any], NDArray[Any]]]
) -> Figure:
    """Draw the means over the fleet of NEES and NIS, each with its 95 % interval."""
    figure, axes = subplots(len(judged), 2, height_in=4.4, sharex=True, sharey=True)
    time_s = run.time_s[: run.cycles]
    for row, (quantity, nees, nis) in zip(axes, judged, strict=True):
        for axis, name, squares in zip(row, ("NEES", "NIS"), (nees, nis), strict=True):
            axis.set_title(f"{name}, {quantity.name}")
            mean = consistency(squares)
            if mean is None:
                axis.text(0.5, 0.5, "none", ha="center", transform=axis.transAxes)
                continue
            axis.fill_between(time_s, mean.low, mean.high, **_BAND, label="95 %")
            axis.plot(time_s, mean.per_cycle, ".", **_DOTS, label="mean")
            for edge in (mean.low, mean.high):
                axis.plot(time_s, edge, color=TRUE, lw=0.8)
        row[0].set_ylabel("mean over the fleet")
    axes[0, 0].set_yscale("log")
    plain_log(axes[0, 0].yaxis)
    axes[0, 0].set_xlim(time_s[0], max(time_s[-1], time_s[0] + 1e-3))
    for axis in axes.flat:
        mark(axis, happenings(run))
    figure_legend(figure, *axes.flat, markerscale=4)
    for axis in axes[-1]:
        axis.set_xlabel("time, s")
    return _typed(figure)


def _window(run: Run) -> NDArray[np.int64]:
    """Return the rows around the first disturbance, or from the start if there is none."""
    start_s, end_s = around_first(run, _BEFORE_S, _WINDOW_S)
    time_s = run.time_s[: run.cycles]
    shown = np.flatnonzero((time_s >= start_s) & (time_s <= end_s))
    return shown if shown.size else np.arange(len(time_s))


def _title(kind: str, quantity: Quantity, values: NDArray[Any], true: NDArray[Any]) -> str:
    found = agreement(values, true)
    if found is None:
        return f"{kind}: none"
    r2 = meaningful_r2(found.r2)
    beside = "" if r2 is None else f", R² {r2:.2f}"
    return f"{kind}: RMSE {found.rmse:.2f} {quantity.unit}{beside}"


def _typed(figure: Any) -> Figure:
    assert isinstance(figure, Figure)
    return figure
