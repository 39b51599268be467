"""The results of an analysis: tables and pictures under a title, for terminal, page and files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from matplotlib.figure import Figure

Cell = str | int | float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """A table. `name` is the stem of its CSV file; columns name their units ("gap, m").

    Every row has a cell for each column. None stands for what does not apply.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""

    def without_empty(self) -> Sheet | None:
        """Return the sheet without empty rows and columns, for people; None where nothing remains.

        A row or column is empty if it holds only None besides its name. The CSV file keeps them, so
        that it has the same rows and columns in every run.
        """
        if not self.rows:
            return self
        names = self.columns.index("unit") + 1 if "unit" in self.columns else 1
        rows = [row for row in self.rows if len(row) <= names or not _empty(row[names:])]
        kept = [k for k in range(len(self.columns)) if k < names or not _empty(r[k] for r in rows)]
        if not rows or len(kept) == names < len(self.columns):
            return None
        return replace(
            self,
            columns=tuple(self.columns[k] for k in kept),
            rows=tuple(tuple(row[k] for k in kept) for row in rows),
        )


def _empty(cells: Iterable[Cell]) -> bool:
    return all(cell is None for cell in cells)


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure, which is drawn on demand. `name` is the stem of its files.

    The caption says in full sentences what is plotted and what to look for.
    """

    name: str
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A chapter of a report. `notes` say what is missing for this run, and why."""

    title: str
    sheets: tuple[Sheet, ...] = ()
    pictures: tuple[Picture, ...] = ()
    notes: tuple[str, ...] = ()
