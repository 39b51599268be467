"""Formats numbers for people: significant digits only, and the same decimals in a column."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from zenvoy.analysis.page.section import Cell, Sheet

ABSENT: Final = "–"
_SIGNIFICANT: Final = 4  # digits of the largest number of a column
_SMALLEST: Final = 2  # digits of its smallest number, if one more decimal is enough for them
_SPREAD: Final = 1e4  # columns that span more have no common number of decimals
_MAX_DECIMALS: Final = 6
_MAX_SIDE_BY_SIDE: Final = 6  # a single row with more columns than this is turned
_FIXED: Final = (1e-4, 1e7)  # magnitudes that are written without an exponent


class Column(NamedTuple):
    """A column as it is shown; numbers are aligned to the right."""

    title: str
    number: bool
    cells: list[str]

    @property
    def longest(self) -> int:
        """Length of the longest cell, characters."""
        return max(map(len, self.cells), default=0)

    @property
    def longest_word(self) -> int:
        """Length of the longest word in any cell, characters."""
        return max((len(word) for cell in self.cells for word in cell.split()), default=0)


def columns(sheet: Sheet, most_rows: int) -> list[Column]:
    """Return the first rows of a sheet, column by column.

    In a sheet with a column "unit" each row is a quantity, so decimals are the same within a row.
    A single row with many columns is turned into one row per column.
    """
    rows = sheet.rows[:most_rows]
    if len(rows) == 1 and len(sheet.columns) > _MAX_SIDE_BY_SIDE:
        values = list(map(text, rows[0]))
        return [Column("figure", False, list(sheet.columns)), Column("value", True, values)]
    cells = [[row[index] for row in rows] for index in range(len(sheet.columns))]
    if "unit" in sheet.columns:
        by_row = [_row_texts(row) for row in rows]
        shown = [[row[index] for row in by_row] for index in range(len(sheet.columns))]
    else:
        shown = list(map(texts, cells))
    numbers = [any(isinstance(cell, int | float) for cell in column) for column in cells]
    return list(map(Column, sheet.columns, numbers, shown))


def _row_texts(row: Sequence[Cell]) -> list[str]:
    numbers = iter(texts([cell for cell in row if not isinstance(cell, str)]))
    return [cell if isinstance(cell, str) else next(numbers) for cell in row]


def texts(column: Sequence[Cell]) -> list[str]:
    """Return the text of the cells of a column; None and NaN become "–".

    All cells have the same decimals: enough for four significant digits of the largest number, and
    one more if the smallest would have fewer than two. In a column that contains text, or that
    spans more than four orders of magnitude, each cell has four significant digits.
    """
    known = [abs(cell) for cell in column if isinstance(cell, float) and math.isfinite(cell)]
    sizes = [size for size in known if size > 0.0]
    alike = not any(isinstance(cell, str) for cell in column)
    if not sizes or not alike or max(sizes) >= _SPREAD * min(sizes):
        return [text(cell) for cell in column]
    enough = _decimals(max(sizes), _SIGNIFICANT)
    wanted = max(enough, min(enough + 1, _decimals(min(sizes), _SMALLEST)))
    decimals = min(wanted, max(map(_needed, known)))
    return [_fixed(cell, decimals) if isinstance(cell, float) else text(cell) for cell in column]


def text(cell: Cell) -> str:
    """Return the text of a single cell."""
    if cell is None:
        return ABSENT
    if isinstance(cell, str):
        return cell
    if isinstance(cell, int):
        return _grouped(cell)
    size = abs(cell)
    if not math.isfinite(cell) or size == 0.0 or _FIXED[0] <= size < _FIXED[1]:
        decimals = _decimals(size, _SIGNIFICANT) if 0.0 < size < math.inf else 0
        return _fixed(cell, min(decimals, _needed(size)))
    return _signed(f"{cell:.{_SIGNIFICANT - 1}e}")


def _fixed(value: float, decimals: int) -> str:
    if math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "∞" if value > 0.0 else "−∞"
    written = f"{value:.{decimals}f}"
    return _signed(written if float(written) else written.lstrip("-"))


def _decimals(size: float, digits: int) -> int:
    """Return the decimals at which a number of this size has `digits` significant digits."""
    return min(_MAX_DECIMALS, max(0, digits - 1 - math.floor(math.log10(size))))


def _needed(size: float) -> int:
    """Return the decimals that write a number in full: none for 500.0, one for 0.1."""
    if not math.isfinite(size):
        return 0
    written = f"{size:.9f}".rstrip("0")
    return len(written.partition(".")[2])


def _grouped(value: int) -> str:
    """Separate thousands in numbers of more than four digits, by a no-break space."""
    written = f"{value:,}".replace(",", "\u00a0") if abs(value) >= 10_000 else str(value)
    return _signed(written)


def _signed(written: str) -> str:
    return written.replace("-", "−")
