"""Reads columns of numbers from a grid of cells."""

from __future__ import annotations

import re
from collections.abc import Sequence
from decimal import Decimal
from typing import Final

import numpy as np

from zenvoy.scenarios.convoys.convoy import Floats
from zenvoy.scenarios.convoys.errors import Faults, refused
from zenvoy.scenarios.reading.grid import Grid, Row
from zenvoy.scenarios.schema.units import Ratio
from zenvoy.values.wording import listed, shown

_NUMBER: Final = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def rows_of(grid: Grid, source: str) -> tuple[list[int], list[Row]]:
    """Return the lines and the rows below the header; raises ConvoyError if one is incomplete."""
    faults, lines, rows = Faults(source), [], []
    width = len(grid.header)
    for line, row in grid.rows():
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) != width:
            columns = listed(grid.header)
            faults.add("", "width", f"a row of {len(row)} is not a row of {width}, {columns}", line)
        lines.append(line)
        rows.append(row)
    faults.refuse()
    if not rows:
        raise refused(source, "", "there is no row below the header", grid.header_line)
    return lines, rows


def numbers_in(
    grid: Grid, rows: Sequence[Row], lines: Sequence[int], column: int, faults: Faults
) -> Floats:
    """Return a column of numbers (T,); an empty cell is NaN, and any other text is a fault."""
    name = grid.header[column]
    found = np.full(len(rows), np.nan)
    for index, (line, row) in enumerate(zip(lines, rows, strict=True)):
        cell = row[column]
        if not cell:
            continue
        if _NUMBER.fullmatch(cell):
            found[index] = float(cell)
        else:
            faults.add(name, "number", f"{shown(cell)} is not a number", line)
    return found


def scaled(values: Floats, ratio: Ratio) -> Floats:
    """Return values in m/s or s, from values in a unit of that ratio."""
    if ratio[0] == ratio[1]:
        return values
    return np.asarray(values * float(ratio[0] / Decimal(ratio[1])))


def column_named(grid: Grid, name: str, option: str, source: str) -> int:
    """Return the index of the only column of a name; raises ConvoyError."""
    count = grid.header.count(name)
    if count == 1:
        return grid.header.index(name)
    columns = [cell for cell in grid.header if cell]
    text = f"{shown(name)} is not a column; allowed: one of {listed(columns)}"
    if count > 1:
        text = f"{shown(name)} is the name of {count} columns; allowed: of one"
    raise refused(source, option, text, grid.header_line)
