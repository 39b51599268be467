"""Splits the text of a table into cells: delimiter, comments, and lines above the header."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

DELIMITERS: Final = ("\t", ";", ",")
_COMMENTS: Final = ("#", "%", "//")
_LAST_LINE_OF_A_HEADER: Final = 1_000
_LINES: Final = re.compile(r"\r\n|\r|\n")

Row = list[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A header and the rows below it. Lines count from 1; the header's cells are stripped."""

    delimiter: str
    header: tuple[str, ...]
    header_line: int
    lines: tuple[str, ...]

    def rows(self) -> Iterator[tuple[int, Row]]:
        """Yield the rows below the header with their lines, without blank lines and comments."""
        for line, text in enumerate(self.lines[self.header_line :], start=self.header_line + 1):
            if text.strip() and not text.lstrip().startswith(_COMMENTS):
                yield line, cells(text, self.delimiter)


def grid_of(text: str, is_header: Callable[[Row], bool]) -> Grid | None:
    """Return the table under the first line of `text` that is a header; None if there is none.

    A header may begin with a comment sign, as numpy's savetxt writes it.
    """
    lines = _lines(text)
    for line, row_text in enumerate(lines[:_LAST_LINE_OF_A_HEADER], start=1):
        for delimiter in DELIMITERS:
            row = cells(_uncommented(row_text), delimiter)
            if len(row) > 1 and is_header(row):
                header = tuple(row)
                return Grid(delimiter=delimiter, header=header, header_line=line, lines=lines)
    return None


def likely_header(text: str) -> tuple[int, Row] | None:
    """Return the last line of several cells before a row that begins with a number.

    The result is the number of that line and its cells. It is None if there is no such row, because
    then the text is not a table.
    """
    best: tuple[int, Row] | None = None
    for line, row_text in enumerate(_lines(text)[:_LAST_LINE_OF_A_HEADER], start=1):
        row = cells(_uncommented(row_text), _delimiter_in(row_text))
        if len(row) > 1 and is_number(row[0]):
            return best
        if len(row) > 1:
            best = (line, row)
    return None


def cells(text: str, delimiter: str) -> Row:
    """Return the cells of a line, stripped."""
    if '"' in text:
        row = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
    else:
        row = text.split(delimiter)
    return [cell.strip() for cell in row]


def is_number(cell: str) -> bool:
    """Return whether a cell begins like a number."""
    return re.match(r"[+-]?[.,]?\d", cell) is not None


def _lines(text: str) -> tuple[str, ...]:
    return tuple(_LINES.split(text.removeprefix("\ufeff")))


def _uncommented(text: str) -> str:
    return re.sub(r"^\s*(#+|%+|//)\s*", "", text)


def _delimiter_in(text: str) -> str:
    return next((delimiter for delimiter in DELIMITERS if delimiter in text), ",")
