"""Reads tables whose columns are named: a column for each car, or a row for each car and time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from zenvoy.scenarios.convoys.cells import column_named, numbers_in, rows_of, scaled
from zenvoy.scenarios.convoys.checks import check_clock, check_names, check_speeds
from zenvoy.scenarios.convoys.columns import CAR, Columns, no_header
from zenvoy.scenarios.convoys.convoy import Floats, Table
from zenvoy.scenarios.convoys.errors import Faults
from zenvoy.scenarios.reading.grid import Grid, grid_of
from zenvoy.values.wording import shown


def named_table(text: str, source: str, columns: Columns) -> Table:
    """Return the motion of the cars in the text of a table; raises ConvoyError."""
    grid = grid_of(text, lambda row: not columns.missing_in(row))
    if grid is None:
        raise no_header(text, source, columns)
    return (_Wide if columns.vehicle is None else _Long)(grid, source, columns).table()


class _Reader:
    """Reads the rows under a header."""

    def __init__(self, grid: Grid, source: str, columns: Columns) -> None:
        self.grid, self.source, self.columns = grid, source, columns
        self.lines, self.rows = rows_of(grid, source)
        self.faults = Faults(source)
        index = column_named(grid, columns.time, "--time", source)
        self.time_s = scaled(self.numbers(index), columns.time_ratio())

    def numbers(self, index: int) -> Floats:
        """Return a column of numbers."""
        return numbers_in(self.grid, self.rows, self.lines, index, self.faults)

    def checked(self, option: str, index: int) -> Floats:
        """Return a column of motion in m/s or m, and gather what is wrong with it."""
        values, name = self.numbers(index), self.grid.header[index]
        if option == "speed":
            values = scaled(values, self.columns.speed_ratio())
            return check_speeds(values, self.lines, name, self.faults)
        return values


class _Wide(_Reader):
    """A row for each time, with the columns of all cars side by side."""

    def table(self) -> Table:
        """Return the motion of the cars; raises ConvoyError."""
        check_clock(self.time_s, self.lines, self.columns.time, self.faults)
        cars = self._cars()
        motion: dict[str, Floats] = {}
        for option in self.columns.motion:
            there = dict(self.columns.cars_of(option, self.grid.header))
            empty = np.full(len(self.rows), np.nan)
            motion[option] = np.array(
                [self.checked(option, there[car]) if car in there else empty for car in cars]
            ).T
        self.faults.refuse()
        gap = "" if self.columns.gap is None else self.columns.gap
        return Table(
            cars=cars,
            numbers=_numbers(cars),
            time_s=self.time_s,
            speed=motion.get("speed"),
            position=motion.get("position"),
            gap=motion.get("gap"),
            gap_columns=tuple(gap.replace(CAR, car) for car in cars),
            gap_lines=np.repeat(np.array(self.lines)[:, None], len(cars), axis=1),
        )

    def _cars(self) -> tuple[str, ...]:
        """Return the names of the cars; raises ConvoyError if two have one name."""
        first = "position" if self.columns.speed is None else "speed"
        names = [name for name, _ in self.columns.cars_of(first, self.grid.header)]
        check_names(names, self.columns.motion[first], self.faults, self.grid.header_line)
        self.faults.refuse()
        return tuple(names)


class _Long(_Reader):
    """A row for each car and time."""

    def table(self) -> Table:
        """Return the motion of the cars; raises ConvoyError."""
        assert self.columns.vehicle is not None
        index = column_named(self.grid, self.columns.vehicle, "--vehicle", self.source)
        of_rows = [row[index] for row in self.rows]
        cars = [name for name in dict.fromkeys(of_rows) if name]
        rows = {car: [k for k, name in enumerate(of_rows) if name == car] for car in cars}
        for car in cars:
            self._check_clock_of(car, rows[car])
        motion = {
            option: self.checked(option, column_named(self.grid, name, f"--{option}", self.source))
            for option, name in self.columns.motion.items()
        }
        self.faults.refuse()
        times = np.unique(self.time_s[[k for some in rows.values() for k in some]])
        found = {
            option: self._side_by_side(values, times, [rows[car] for car in cars])
            for option, values in motion.items()
        }
        lines = self._side_by_side(
            np.array(self.lines, dtype=np.float64), times, list(rows.values())
        )
        table = Table(
            cars=tuple(cars),
            numbers=_numbers(cars),
            time_s=times,
            speed=found.get("speed"),
            position=found.get("position"),
            gap=found.get("gap"),
            gap_columns=(self.columns.gap or "",) * len(cars),
            gap_lines=np.nan_to_num(lines).astype(np.int64),
        )
        return _front_to_back(table)

    def _check_clock_of(self, car: str, rows: Sequence[int]) -> None:
        """Gather what is wrong with the times of a car; a time that comes twice has a line."""
        lines = [self.lines[k] for k in rows]
        whose = f" of {shown(car)}"
        check_clock(self.time_s[rows], lines, self.columns.time, self.faults, whose)

    def _side_by_side(self, values: Floats, times: Floats, rows: Sequence[Sequence[int]]) -> Floats:
        """Return values (times, cars) of a column, NaN where a car has none."""
        found = np.full((len(times), len(rows)), np.nan)
        for car, some in enumerate(rows):
            found[np.searchsorted(times, self.time_s[list(some)]), car] = values[list(some)]
        return found


def _front_to_back(table: Table) -> Table:
    """Return the cars in the order of their positions at the first time that has all of them."""
    if table.position is None:
        return table
    whole = np.flatnonzero(np.isfinite(table.position).all(axis=1))
    if not len(whole):
        return table
    order = np.argsort(-table.position[whole[0]], kind="stable")
    return replace(table.of_cars(order.tolist()), numbers=table.numbers)


def _numbers(cars: Sequence[str]) -> tuple[int, ...]:
    return tuple(range(1, len(cars) + 1))
