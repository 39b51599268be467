"""The chapter "String stability" of a report: measurements next to linear theory."""

from __future__ import annotations

from functools import partial
from typing import Final

from zenvoy.analysis.chapters.mode_sheets import mode_sheet
from zenvoy.analysis.chapters.stability_pictures import (
    followers,
    frequency_picture,
    gain_picture,
    mode_picture,
    settled,
    wave_picture,
)
from zenvoy.analysis.chapters.stability_sheets import figure_sheet, stretch_sheet
from zenvoy.analysis.chapters.stability_vehicles import vehicle_sheet
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.section import Picture, Section
from zenvoy.analysis.theory.disturbed import Disturbed, disturbed
from zenvoy.analysis.theory.ring_modes import Modes, measured_modes

_TITLE: Final = "String stability"


def stability_section(run: Run) -> Section:
    """Return gains, waves and modes after the first disturbance, with notes on what is missing."""
    if len(run.time_s) < 2:
        return Section(title=_TITLE, notes=("No cycle was logged, so there is no motion to show.",))
    case = disturbed(run)
    if isinstance(case, str):
        return Section(title=_TITLE, notes=(case,))
    modes = measured_modes(run, case)
    sheets = [figure_sheet(run, case, modes), vehicle_sheet(case)]
    if modes.rows:
        sheets.append(mode_sheet(modes))
    if len(case.stretches) > 1:
        sheets.append(stretch_sheet(run, case))
    return Section(
        title=_TITLE,
        sheets=tuple(sheets),
        pictures=tuple(_pictures(run, case, modes)),
        notes=(*case.notes, *modes.notes, *_frequency_notes(run, case)),
    )


def _frequency_notes(run: Run, case: Disturbed) -> list[str]:
    if settled(run, case)[[*case.backwards, *case.forwards]].all():
        return []
    return [
        "Some vehicles have no gain over frequency. They still accelerate at the beginning or end "
        "of the record, if only by noise, and the Fourier transform would be wrong there."
    ]


def _pictures(run: Run, case: Disturbed, modes: Modes) -> list[Picture]:
    pictures = [
        Picture(
            name="stability-gains",
            caption="Deviation of each vehicle's speed relative to that of the disturbed vehicle: "
            "L2 norm on the left, largest value (L∞) on the right. In a stable string it falls "
            "with the distance from the disturbed vehicle. Points are measured. The line is "
            "linear theory, for the actual motion of the disturbed vehicle.",
            draw=partial(gain_picture, case),
        )
    ]
    if followers(run, case):
        pictures.append(
            Picture(
                name="stability-frequency",
                caption="Gain of speed over frequency, from the disturbed vehicle to some vehicles "
                "behind it: the ratio of the Fourier transforms of their accelerations, at the "
                "frequencies that the disturbance contains. Points are measured, lines are linear "
                "theory.",
                draw=partial(frequency_picture, run, case),
            )
        )
    if case.has_dip and len(case.dips(case.deviation, case.backwards)[0]) > 1:
        pictures.append(
            Picture(
                name="stability-wave",
                caption="Time at which the dip in speed reaches each vehicle. The slope is the "
                "time from one vehicle to the next. Points are measured. The line is linear "
                "theory, for the actual motion of the disturbed vehicle.",
                draw=partial(wave_picture, run, case),
            )
        )
    if modes.rows and modes.slowest is not None:
        pictures.append(
            Picture(
                name="stability-modes",
                caption="Modes of the ring after the disturbance. The left panel shows the rate at "
                "which each mode grows (above 0) or decays; points are measured, the line is "
                "theory. The right panel shows the amplitude of the slowest mode over time. There "
                "the line has the exponents of theory, with weights fitted up to the dashed "
                "line.",
                draw=partial(mode_picture, run, modes),
            )
        )
    return pictures
