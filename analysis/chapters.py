"""The chapters of a report, in their order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from zenvoy.analysis.load import Run
from zenvoy.analysis.section import Section

CHAPTERS: Final[tuple[Callable[[Run], Section], ...]] = ()


def chapters(run: Run) -> tuple[Section, ...]:
    """Every chapter of a run that has motion to show."""
    return tuple(chapter(run) for chapter in CHAPTERS)
