"""What an analysis says: tables and pictures under a title, whoever shows them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

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

    def told(self) -> Sheet | None:
        """The sheet as people are shown it; its CSV file has every row and column in every run.

        Rows and columns that hold None alone, beside what names them, are left out; None where
        nothing remains.
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
