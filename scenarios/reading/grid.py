"""Text of a table of numbers as cells: delimiter, comments, and what stands above the header."""

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
    """Rows below a header. Lines are counted from 1; `header` is stripped of blanks."""

    delimiter: str
    header: tuple[str, ...]
    header_line: int
    lines: tuple[str, ...]

    def rows(self) -> Iterator[tuple[int, Row]]:
        """The rows below the header with their lines, without blank lines and comments."""
        for line, text in enumerate(self.lines[self.header_line :], start=self.header_line + 1):
            if text.strip() and not text.lstrip().startswith(_COMMENTS):
                yield line, cells(text, self.delimiter)


def grid_of(text: str, is_header: Callable[[Row], bool]) -> Grid | None:
    """The table in `text` under the first line that is a header; None where there is none.

    A header may stand behind a sign of comment, as numpy's savetxt writes it.
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
    """The last line of several cells before a row that begins with a number, and which one it is.

    None where there is no such row: then the text is no table, and its words are nobody's columns.
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
    """The cells of a line, without the blanks around them."""
    if '"' in text:
        row = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True), [])
    else:
        row = text.split(delimiter)
    return [cell.strip() for cell in row]


def is_number(cell: str) -> bool:
    """Whether a cell begins as a number does."""
    return re.match(r"[+-]?[.,]?\d", cell) is not None


def _lines(text: str) -> tuple[str, ...]:
    return tuple(_LINES.split(text.removeprefix("\ufeff")))


def _uncommented(text: str) -> str:
    return re.sub(r"^\s*(#+|%+|//)\s*", "", text)


def _delimiter_in(text: str) -> str:
    return next((delimiter for delimiter in DELIMITERS if delimiter in text), ",")
