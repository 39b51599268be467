"""The chapter "String stability" of a run's report: what was measured beside linear theory."""

from __future__ import annotations

from functools import partial
from typing import Final

from zenvoy.analysis.chapters.stability_pictures import (
    followers,
    frequency_picture,
    gain_picture,
    mode_picture,
    settled,
    wave_picture,
)
from zenvoy.analysis.chapters.stability_sheets import figure_sheet, mode_sheet, stretch_sheet
from zenvoy.analysis.chapters.stability_vehicles import vehicle_sheet
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.section import Picture, Section
from zenvoy.analysis.theory.disturbed import Disturbed, disturbed
from zenvoy.analysis.theory.ring_modes import Modes, measured_modes

_TITLE: Final = "String stability"


def stability_section(run: Run) -> Section:
    """Gains, waves and modes after the first disturbance; notes for what cannot be told."""
    if len(run.time_s) < 2:
        return Section(title=_TITLE, notes=("No cycle was logged: there is no motion to judge.",))
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
    if settled(run, case)[[*case.behind, *case.ahead]].all():
        return []
    return [
        "Some vehicles still move (or tremble with noise) where the record begins or ends, and a "
        "Fourier transform would take the cut for motion: they have no gain over frequency."
    ]


def _pictures(run: Run, case: Disturbed, modes: Modes) -> list[Picture]:
    pictures = [
        Picture(
            name="stability-gains",
            caption="How large the deviation of speed is at each vehicle, relative to the "
            "disturbed one: by its L2 norm, and by its largest value. A string is stable where "
            "the points fall. Points: measured; line: what linear theory makes of the disturbed "
            "vehicle's motion.",
            draw=partial(gain_picture, case),
        )
    ]
    if followers(run, case):
        pictures.append(
            Picture(
                name="stability-frequency",
                caption="Gain of speed over frequency, from the disturbed vehicle to some behind "
                "it: ratio of the Fourier transforms of their accelerations, at frequencies at "
                "which the disturbed one moved. Points: measured; lines: linear theory.",
                draw=partial(frequency_picture, run, case),
            )
        )
    if case.has_dip and len(case.dips(case.deviation, case.behind)[0]) > 1:
        pictures.append(
            Picture(
                name="stability-wave",
                caption="When the dip of speed came to each vehicle: the slope is the time it "
                "takes from one to the next. Points: measured; line: linear theory, "
                "from the disturbed vehicle's motion.",
                draw=partial(wave_picture, run, case),
            )
        )
    if modes.rows and modes.slowest is not None:
        pictures.append(
            Picture(
                name="stability-modes",
                caption="Modes of the ring after the disturbance. Left, the rate at which each "
                "grows (above 0) or decays: points measured, line by theory. Right, the slowest "
                "one over time: points measured; line: the two exponents of theory, with the "
                "amplitudes that fit best up to the dashed line, where the fit ends.",
                draw=partial(mode_picture, run, modes),
            )
        )
    return pictures
