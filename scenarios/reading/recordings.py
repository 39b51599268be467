"""Reads speeds over time from published tables: drive cycles and recorded drives."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from decimal import Decimal
from typing import Final

from zenvoy.scenarios.reading.columns import Choice, RecordingError, columns_of, no_header
from zenvoy.scenarios.reading.grid import Grid, Row, grid_of
from zenvoy.scenarios.reading.points import between, longest_gap, scaled
from zenvoy.scenarios.schema.units import SPEEDS, TIMES, Ratio, split_header, unit_named
from zenvoy.values.wording import listed, shown

_NUMBER: Final = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_DATE: Final = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d.*", re.ASCII)
_MISSING: Final = frozenset({"", "nan", "na", "n/a", "null", "none"})
_STANDSTILL_MPS: Final = -0.5  # the error of a speed sensor at standstill is smaller


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """A speed over time: points of (s, m/s), the line of each point, and how they were read.

    missing counts rows without a speed, which are left out; longest_gap_s is the longest time
    between two points around such rows. raised counts rows whose speed was slightly below 0 and
    became 0. others counts rows that `where` leaves out.
    """

    points: tuple[tuple[float, float], ...]
    lines: tuple[int, ...]
    grid: Grid
    column: str
    time_column: str
    unit: str
    time_unit: str
    first_time: str
    from_first: bool
    missing: int
    longest_gap_s: float
    raised: int
    others: int


def recording(text: str, choice: Choice) -> Recording:
    """Return the speed over time in the text of a table; raises RecordingError."""
    grid = grid_of(text, lambda row: columns_of(row, choice) is not None)
    if grid is None:
        raise no_header(text, choice)
    found = columns_of(grid.header, choice)
    assert found is not None
    return _Reader(grid, choice, *found).read()


class _Reader:
    """Reads the rows under a header."""

    def __init__(self, grid: Grid, choice: Choice, time_index: int, index: int) -> None:
        self._grid, self._choice = grid, choice
        self._time_index, self._index = time_index, index
        self._rows = list(grid.rows())
        self._problems: list[tuple[int | None, str, str]] = []
        self._decimal_signs: dict[str, str] = {}  # by column, from the first number with decimals

    def read(self) -> Recording:
        """Read the whole table; raises RecordingError with all problems."""
        header, choice = self._grid.header, self._choice
        time_name, name = header[self._time_index], header[self._index]
        time_unit, unit = self._units()
        wanted = self._wanted_cells()
        self._refuse()
        rows = [(line, row) for line, row in self._rows if self._is_complete(line, row)]
        chosen = [(line, row) for line, row in rows if self._matches(wanted, row)]
        if not chosen and not self._problems:
            what = "no row has these values" if wanted else "there is no row below the header"
            self._problems.append((self._grid.header_line, "where" if wanted else "", what))
        read = [point for line, row in chosen if (point := self._point(line, row))]
        self._refuse()
        present = [(line, time, speed) for line, time, speed in read if speed is not None]
        dates = any(isinstance(time, datetime) for _, time, _ in present)
        from_first = choice.time == "from-first" or (choice.time is None and dates)
        times = self._times(present, TIMES[time_unit], from_first=from_first)
        speeds, raised = self._speeds(present, SPEEDS[unit])
        self._refuse()
        lines = tuple(line for line, _, _ in present)
        return Recording(
            points=tuple(zip(times, speeds, strict=True)),
            lines=lines,
            grid=self._grid,
            column=name,
            time_column=time_name,
            unit=unit,
            time_unit="date" if dates else time_unit,
            first_time=str(present[0][1]) if present else "",
            from_first=from_first,
            missing=len(read) - len(present),
            longest_gap_s=longest_gap(read, lines, times),
            raised=raised,
            others=len(rows) - len(chosen),
        )

    def _refuse(self) -> None:
        if self._problems:
            raise RecordingError(self._problems)

    def _units(self) -> tuple[str, str]:
        """Return the units of times, by default s, and of speeds, which has no default."""
        below: list[str | None] = [None, None]
        if self._rows:  # the row below the header may hold the units
            row = self._rows[0][1]
            below = [
                unit_named(row[index], units) if index < len(row) else None
                for index, units in ((self._time_index, TIMES), (self._index, SPEEDS))
            ]
            if all(below):
                del self._rows[0]
        header = self._grid.header
        time_unit = self._choice.time_unit or below[0]
        time_unit = time_unit or split_header(header[self._time_index], TIMES)[1] or "s"
        unit = self._choice.unit or below[1] or split_header(header[self._index], SPEEDS)[1]
        if unit is None:
            name = shown(header[self._index])
            text = f"not given, and {name} names no unit; allowed: one of {', '.join(SPEEDS)}"
            self._problems.append((self._grid.header_line, "unit", text))
        return time_unit, unit or "m/s"

    def _wanted_cells(self) -> dict[int, str]:
        """Return the values of `where` by index of the column."""
        wanted = {}
        for name, value in self._choice.where.items():
            if self._grid.header.count(name) != 1:
                columns = listed(self._grid.header)
                text = f"{shown(name)} is not a column; allowed: one of {columns}"
                self._problems.append((self._grid.header_line, "where", text))
            else:
                wanted[self._grid.header.index(name)] = value
        return wanted

    def _is_complete(self, line: int, row: Row) -> bool:
        width = len(self._grid.header)
        while len(row) > width and not row[-1]:
            row.pop()
        if len(row) == width:
            return True
        text = f"a row of {len(row)} is not a row of {width}, {listed(self._grid.header)}"
        self._problems.append((line, "", text))
        return False

    @staticmethod
    def _matches(wanted: Mapping[int, str], row: Row) -> bool:
        return all(row[index] == value for index, value in wanted.items())

    def _point(self, line: int, row: Row) -> tuple[int, str | datetime, str | None] | None:
        """Return line, time and speed as text with a decimal point; a missing speed is None."""
        at, speed = row[self._time_index], row[self._index]
        header = self._grid.header
        time = self._date(at) or self._number(line, header[self._time_index], at)
        is_missing = speed.lower() in _MISSING
        value = None if is_missing else self._number(line, header[self._index], speed)
        if time is None or (value is None and not is_missing):
            return None
        return line, time, value

    @staticmethod
    def _date(cell: str) -> datetime | None:
        if not _DATE.fullmatch(cell):
            return None
        try:
            return datetime.fromisoformat(cell)
        except ValueError:
            return None

    def _number(self, line: int, name: str, cell: str) -> str | None:
        comma = "," in cell
        if not _NUMBER.fullmatch(cell) or (comma and self._grid.delimiter == ","):
            self._problems.append((line, "", f"{name}: {shown(cell)} is not a number"))
            return None
        sign = "," if comma else "." if "." in cell else ""
        other = self._decimal_signs.setdefault(name, sign) if sign else sign
        if other != sign:  # it may be a thousands separator
            text = f"{name}: {shown(cell)} has {sign!r} where others have {other!r}"
            self._problems.append((line, "", text))
            return None
        return cell.replace(",", ".") if comma else cell

    def _times(
        self,
        present: Sequence[tuple[int, str | datetime, object]],
        ratio: Ratio,
        *,
        from_first: bool,
    ) -> list[float]:
        """Return the times in s, as given or from the first one on."""
        given = [time for _, time, _ in present]
        if any(isinstance(time, datetime) for time in given):
            return self._dates(present, from_first=from_first)
        if not from_first:
            return [scaled(str(time), ratio) for time in given]
        exact = [Decimal(str(time)) for time in given]
        return [float((time - exact[0]) * ratio[0] / ratio[1]) for time in exact]

    def _dates(
        self, present: Sequence[tuple[int, str | datetime, object]], *, from_first: bool
    ) -> list[float]:
        """Return the seconds from the first date on, exact to the microsecond."""
        if not from_first:
            text = "as-given, but the times are dates; allowed: from-first"
            self._problems.append((present[0][0], "time", text))
            return []
        first, seconds = present[0][1], []
        for line, time, _ in present:
            passed = between(first, time)
            if passed is None:
                text = f"{shown(str(time))} and the first time are not dates of one kind"
                self._problems.append((line, "", text))
            else:
                seconds.append(passed.total_seconds())
        return seconds

    @staticmethod
    def _speeds(
        present: Sequence[tuple[int, object, str | None]], ratio: Ratio
    ) -> tuple[list[float], int]:
        """Return the speeds in m/s, and how many were slightly below 0."""
        speeds = [scaled(speed, ratio) for _, _, speed in present if speed is not None]
        raised = sum(_STANDSTILL_MPS <= speed < 0.0 for speed in speeds)
        return [0.0 if _STANDSTILL_MPS <= speed < 0.0 else speed for speed in speeds], raised
