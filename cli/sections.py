"""Prints the chapters of an analysis, on terminals of any width."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import wrap
from typing import Final

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from zenvoy.analysis.page.digits import Column, columns
from zenvoy.analysis.page.section import Section, Sheet

MAX_ROWS: Final = 20  # rows of a table on the terminal; its CSV file has them all
_SPACING: Final = 3  # characters between two columns
_TITLE_WIDTHS: Final = (40, 12, 9)  # widths of titles to try; the first at which a table fits
_LEAST_TEXT_WIDTH: Final = 24


def print_section(console: Console, section: Section) -> None:
    """Print the title, notes and tables of a section, but no pictures."""
    console.print(Text(f"\n{section.title}", style="bold"))
    for note in section.notes:
        console.print(Padding(Text(note), (0, 0, 0, 2)))
    for sheet in section.sheets:
        filled = sheet.without_empty()
        if filled is not None:
            _print_sheet(console, filled)


def _print_sheet(console: Console, sheet: Sheet) -> None:
    shown = columns(sheet, MAX_ROWS)
    fitting = (title for title in _TITLE_WIDTHS if _widths(shown, title) <= console.width)
    title = next(fitting, _TITLE_WIDTHS[-1])
    console.print(Text(f"\n{sheet.title}", style="italic"))
    for number, block in enumerate(_blocks(shown, title, console.width)):
        if number:
            console.print()
        console.print(_table(block, title))
    if len(sheet.rows) > MAX_ROWS:
        of = f"{MAX_ROWS} of {len(sheet.rows)} rows"
        text = f"Only the first {of} are shown; {sheet.name}.csv has all."
        console.print(Text(text, style="dim"))
    if sheet.note:
        console.print(Text(sheet.note, style="dim"))


def _blocks(shown: Sequence[Column], title: int, width: int) -> Iterator[list[Column]]:
    """Yield columns that fit side by side, each time after the columns that name the rows."""
    lead = shown[: 2 if len(shown) > 1 and shown[1].title == "unit" else 1]
    block = list(lead)
    for column in shown[len(lead) :]:
        if len(block) > len(lead) and _widths([*block, column], title) > width:
            yield block
            block = list(lead)
        block.append(column)
    yield block


def _widths(shown: Sequence[Column], title: int) -> int:
    return sum(_width(column, title) for column in shown) + _SPACING * (len(shown) - 1)


def _width(column: Column, title: int) -> int:
    """Return the least width of a column: numbers and words stay whole, the rest is folded."""
    words = max(map(len, column.title.split()), default=0)
    cells = column.longest if column.number else min(column.longest, _LEAST_TEXT_WIDTH)
    return max(cells, words, min(len(column.title), title))


def _table(shown: Sequence[Column], title: int) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column in shown:
        if column.number:  # rich folds a title only where it may fold the numbers below it
            lines = wrap(column.title, _width(column, title))
            table.add_column(Text("\n".join(lines)), justify="right", no_wrap=True)
        else:
            table.add_column(Text(column.title), overflow="fold")
    for row in zip(*(column.cells for column in shown), strict=True):
        table.add_row(*map(Text, row))
    return table
