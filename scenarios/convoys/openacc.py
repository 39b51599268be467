"""Reads recordings in the form of OpenACC: some lines on the drive, then a table of all cars.

The cars of a platoon are side by side in it: Speed1, Speed2, … in m/s, in the order of the line
`Vehicle_order`. IVS1 is the spacing from bumper to bumper between cars 1 and 2, in m.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from zenvoy.scenarios.convoys.cells import column_named, numbers_in, rows_of
from zenvoy.scenarios.convoys.checks import check_clock, check_names, check_speeds
from zenvoy.scenarios.convoys.convoy import Floats, Table
from zenvoy.scenarios.convoys.errors import Faults, refused
from zenvoy.scenarios.reading.grid import Grid, Row, cells, grid_of

_SPEED: Final = re.compile(r"Speed([1-9]\d{0,2})", re.ASCII)
_SETTINGS: Final = {"S": "short", "M": "medium", "L": "long", "X": "extra long"}
_ORDER: Final = "Vehicle_order"


def is_openacc(text: str) -> bool:
    """Return whether the text has a header of this form."""
    return grid_of(text, _is_header) is not None


def openacc_table(text: str, source: str, name: str) -> Table:
    """Return the motion of the cars in the text of a file; raises ConvoyError.

    Only the name of a file says that some cars were driven by humans and others by their ACC.
    """
    grid = grid_of(text, _is_header)
    if grid is None:
        what = "no line is the header Time, Speed1, … of OpenACC"
        raise refused(source, "", what if text.strip() else "empty")
    reader = _Reader(grid, source)
    about = reader.about()
    return replace(reader.table(about), setting=_setting(about, name))


class _Reader:
    """Reads the rows below a header, and the lines above it."""

    def __init__(self, grid: Grid, source: str) -> None:
        self._grid, self._source, self._faults = grid, source, Faults(source)

    def about(self) -> dict[str, Row]:
        """Return the lines above the header, by their first cell."""
        lines = self._grid.lines[: self._grid.header_line - 1]
        above = [cells(line, self._grid.delimiter) for line in lines]
        return {row[0]: _without_empty_end(row[1:]) for row in above}

    def table(self, about: Mapping[str, Row]) -> Table:
        """Return the motion of the cars; raises ConvoyError."""
        numbers = sorted(int(found[1]) for cell in self._grid.header
                         if (found := _SPEED.fullmatch(cell)))  # fmt: skip
        cars = self._names(about.get(_ORDER, []), numbers)
        lines, rows = rows_of(self._grid, self._source)
        time_s = self._column("Time", rows, lines)
        check_clock(time_s, lines, "Time", self._faults)
        speed = [check_speeds(self._column(name := f"Speed{number}", rows, lines), lines, name,
                              self._faults) for number in numbers]  # fmt: skip
        gap = [self._column(f"IVS{number - 1}", rows, lines) for number in numbers]
        self._faults.refuse()
        return Table(
            cars=cars,
            numbers=tuple(numbers),
            time_s=time_s,
            speed=np.array(speed).T,
            gap=np.array(gap).T,
            gap_columns=tuple(f"IVS{number - 1}" for number in numbers),
            gap_lines=np.repeat(np.array(lines)[:, None], len(numbers), axis=1),
        )

    def _line_of_order(self) -> int:
        """Return the line that names the cars, or else that of the header."""
        above = self._grid.lines[: self._grid.header_line - 1]
        found = (number for number, line in enumerate(above, start=1) if line.startswith(_ORDER))
        return next(found, self._grid.header_line)

    def _names(self, order: Sequence[str], numbers: Sequence[int]) -> tuple[str, ...]:
        """Return the names of the cars with these numbers."""
        line = self._line_of_order()
        check_names(order, _ORDER, self._faults, line)
        for name in ("Time", *(f"Speed{number}" for number in numbers)):
            column_named(self._grid, name, "", self._source)
        if len(order) < numbers[-1]:
            text = f"{len(order)} names, and there is a column Speed{numbers[-1]}"
            self._faults.add(_ORDER, "count", text, line)
        self._faults.refuse()
        return tuple(order[number - 1] for number in numbers)

    def _column(self, name: str, rows: Sequence[Row], lines: Sequence[int]) -> Floats:
        """Return a column, or no values if there is no such column."""
        if name not in self._grid.header:
            return np.full(len(rows), np.nan)
        index = column_named(self._grid, name, "", self._source)
        return numbers_in(self._grid, rows, lines, index, self._faults)


def _is_header(row: Row) -> bool:
    return row[0] == "Time" and any(map(_SPEED.fullmatch, row))


def _without_empty_end(row: Row) -> Row:
    while row and not row[-1]:
        row = row[:-1]
    return row


def _setting(about: Mapping[str, Row], name: str) -> str:
    """Return how the cars were driven: "humans", "mixed", "ACC, short setting", …"""
    if "mixed" in name:
        return "mixed"
    if about.get("ACC") == ["0"]:
        return "humans"
    letter = "".join(about.get("Distance_setting", []))
    return f"ACC, {_SETTINGS[letter]} setting" if letter in _SETTINGS else "ACC"
