"""A calibration as a table and a picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from zenvoy.analysis.page import style
from zenvoy.analysis.page.section import Cell, Picture, Section, Sheet
from zenvoy.studies.convoys.calibration import Calibration, Held
from zenvoy.studies.convoys.fitting import Fit

_COLUMNS = 3  # of small pictures


def calibration_section(found: Calibration) -> Section:
    """Return the table of a calibration, and its picture."""
    law = found.law.name
    return Section(
        title=f"{law} fitted to {found.convoy.name}",
        notes=tuple(_notes(found)),
        sheets=(_sheet(found),),
        pictures=(
            Picture(
                name="calibration",
                caption=(
                    f"The gap of each follower, from bumper to bumper: as recorded (black), and "
                    f"of a vehicle under {law} with the fitted numbers, which begins alike and "
                    "follows the recorded car ahead (coloured)."
                ),
                draw=lambda: _drawn(found),
            ),
        ),
    )


def _sheet(found: Calibration) -> Sheet:
    names = [one.name for one in found.task.free]
    rows = [
        _row(fit, names, float(pair.gap.std()), held)
        for fit, pair, held in zip(found.fits, found.pairs, found.held, strict=True)
    ]
    held = ("held out: error of gap, m", "held out: error of speed, m/s")
    return Sheet(
        name="calibration",
        title="Fitted numbers and errors",
        columns=("car", *names, "spread of gap, m", "error of gap, m", "error of speed, m/s",
                 *held, "at an end of its range"),
        rows=tuple(rows),
        note="Errors are root mean squares over the recording. The spread of the recorded gap is "
        "the error of a constant gap. Held out: over the other recordings that have the car.",
    )  # fmt: skip


def _row(fit: Fit, names: list[str], spread_m: float, held: Sequence[Held]) -> tuple[Cell, ...]:
    return (
        fit.car,
        *(fit.values[name] for name in names),
        spread_m,
        fit.rms_gap_m,
        fit.rms_speed_mps,
        _together([one.rms_gap_m for one in held]),
        _together([one.rms_speed_mps for one in held]),
        ", ".join(fit.at_bound) or None,
    )


def _together(errors: list[float]) -> float | None:
    """Return the root mean square of errors; None for no errors."""
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None


def _notes(found: Calibration) -> list[str]:
    ends = sum(bool(fit.at_bound) for fit in found.fits)
    if not ends:
        return []
    return [
        f"{ends} of {len(found.fits)} fits end at an end of a range: the recording does not "
        "determine these numbers, or wants others. --bound sets a range."
    ]


def _drawn(found: Calibration) -> Figure:
    count = len(found.fits)
    rows = -(-count // _COLUMNS)
    figure, axes = style.subplots(rows, _COLUMNS, height_in=0.6 + 1.5 * rows, sharex=True,
                                  squeeze=False)  # fmt: skip
    period_s = found.task.timing.period_s
    colour = found.law.colour or style.CYCLE[0]
    for axis, fit, pair in zip(axes.flat, found.fits, found.pairs, strict=False):
        time_s = np.arange(len(pair.gap)) * period_s
        axis.plot(time_s, pair.gap, color=style.TRUE, label="recorded")
        axis.plot(time_s, found.task.drive(fit.values, pair).gap, color=colour,
                  label=found.law.name)  # fmt: skip
        axis.set_title(style.plain(fit.car), loc="left")
        axis.set_ylim(bottom=0.0)
    for axis in axes.flat[count:]:
        axis.set_axis_off()
    for axis in axes[:, 0]:
        axis.set_ylabel("gap, m")
    for axis in axes[-1]:
        axis.set_xlabel("time, s")
    style.figure_legend(figure, axes[0, 0])
    return figure
