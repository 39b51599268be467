"""Prints the chapters of an analysis, on terminals of any width."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from zenvoy.analysis.digits import Column, columns
from zenvoy.analysis.section import Section, Sheet

MOST_ROWS: Final = 50  # of a table on the terminal; its CSV has them all
_PADDING: Final = 2  # columns of the terminal between two of a table
_TITLE: Final = 12  # a title is not folded to less than this
_TEXT: Final = 24  # nor a text


def print_section(console: Console, section: Section) -> None:
    """Title, notes and tables; pictures are not for terminals."""
    console.print(Text(f"\n{section.title}", style="bold"))
    for note in section.notes:
        console.print(Padding(Text(note), (0, 0, 0, 2)))
    for sheet in section.sheets:
        _print_sheet(console, sheet)


def _print_sheet(console: Console, sheet: Sheet) -> None:
    console.print(Text(f"\n{sheet.title}", style="italic"))
    for number, block in enumerate(_blocks(columns(sheet, MOST_ROWS), console.width)):
        if number:
            console.print()
        console.print(_table(block))
    if len(sheet.rows) > MOST_ROWS:
        text = f"The first {MOST_ROWS} of {len(sheet.rows)} rows; {sheet.name}.csv has them all."
        console.print(Text(text, style="dim"))
    if sheet.note:
        console.print(Text(sheet.note, style="dim"))


def _blocks(shown: Sequence[Column], width: int) -> Iterator[list[Column]]:
    """Columns that fit beside each other, after those that say what the rows are."""
    lead = shown[: 2 if len(shown) > 1 and shown[1].title == "unit" else 1]
    block = list(lead)
    for column in shown[len(lead) :]:
        if len(block) > len(lead) and sum(map(_width, [*block, column])) > width:
            yield block
            block = list(lead)
        block.append(column)
    yield block


def _width(column: Column) -> int:
    """What a column takes at the least: numbers whole, titles and texts folded."""
    words = max(map(len, column.title.split()), default=0)
    title = max(words, min(len(column.title), _TITLE))
    cells = column.longest if column.number else min(column.longest, _TEXT)
    return max(cells, title) + _PADDING


def _table(shown: Sequence[Column]) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for title, number, _ in shown:
        table.add_column(
            Text(title), justify="right" if number else "left", no_wrap=number, overflow="fold"
        )
    for row in zip(*(cells for _, _, cells in shown), strict=True):
        table.add_row(*map(Text, row))
    return table
