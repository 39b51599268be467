"""The list of a report's chapters, in order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from zenvoy.analysis.chapters.estimation import estimation_section
from zenvoy.analysis.chapters.faults import faults_section
from zenvoy.analysis.chapters.manoeuvres import manoeuvres_section
from zenvoy.analysis.chapters.motion import motion_section
from zenvoy.analysis.chapters.punctuality import punctuality_section
from zenvoy.analysis.chapters.stability import stability_section
from zenvoy.analysis.chapters.v2v import v2v_section
from zenvoy.analysis.log.load import Run
from zenvoy.analysis.page.section import Section

CHAPTERS: Final[tuple[Callable[[Run], Section], ...]] = (
    motion_section,
    stability_section,
    estimation_section,
    v2v_section,
)


def chapters(run: Run) -> tuple[Section, ...]:
    """Return every chapter for a run that has motion to show; raises LogError."""
    live = (punctuality_section,) if run.scenario.clock == "realtime" else ()
    motion, *others = (chapter(run) for chapter in (*CHAPTERS, *live))
    sometimes = (manoeuvres_section(run), faults_section(run))
    return (motion, *(section for section in sometimes if section is not None), *others)
