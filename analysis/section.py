"""What an analysis says: tables and pictures under a title, whoever shows them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

Cell = str | int | float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """A table: `name` is the stem of its CSV file; columns carry their units ("gap, m").

    None stands for what does not apply; every row has a cell for each column.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure, drawn when asked for: `name` is the stem of its files, `caption` says what it is.

    The caption tells what is plotted and what to see in it, in full sentences.
    """

    name: str
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A chapter of a report. `notes` say what could not be told of this run, and why."""

    title: str
    sheets: tuple[Sheet, ...] = ()
    pictures: tuple[Picture, ...] = ()
    notes: tuple[str, ...] = ()
