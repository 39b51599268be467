"""Cuts a convoy out of a table: cars that follow each other, and a stretch of time without holes.

It takes the chain of successive cars and the stretch of time with the most seconds of following.
Straight lines bridge holes of up to a second.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from zenvoy.scenarios.convoys.checks import check_gaps
from zenvoy.scenarios.convoys.convoy import Convoy, Floats, Table
from zenvoy.scenarios.convoys.errors import ConvoyError, Faults, refused
from zenvoy.scenarios.errors import Problem
from zenvoy.values.wording import listed, shown, trimmed

LENGTH_M: Final = 5.0  # the default of fleet.length_m
_BRIDGED_S: Final = 1.0
_LEAST_S: Final = 5.0
_STEP_S: Final = 0.1  # the default period of a scenario
_ROUNDING_S: Final = 1e-6
_MOST_CARS: Final = 100

Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What to take from a table: names or numbers of cars, front to back, and times as in the file.

    None: as much as there is. length_m is the length of all cars, by which positions become gaps.
    With skip_negative_gaps a gap below 0 counts as missing, and is not refused.
    """

    cars: tuple[str, ...] | None = None
    from_s: float | None = None
    to_s: float | None = None
    length_m: float = LENGTH_M
    skip_negative_gaps: bool = False


class _Motion(NamedTuple):
    """Time (T,), speed and gap (T, n) of the cars of a table."""

    time_s: Floats
    speed: Floats
    gap: Floats


class _Cut(NamedTuple):
    """Cars and rows of a table, both from first to last, and the seconds of following in them."""

    cars: slice
    rows: slice
    followed_s: float


def convoy_in(table: Table, choice: Choice, name: str, source: str) -> Convoy:
    """Return the convoy in a table; raises ConvoyError if no cars follow each other in it."""
    table = _with_gaps(_chosen(table, choice, source), choice, source)
    motion = _motion(table)
    cut = _longest(table, motion)
    if cut is None or np.ptp(motion.time_s[cut.rows]) < _LEAST_S:
        text = f"no two cars follow each other for {_LEAST_S:g} s: their speeds and the gaps "
        text += f"between them have holes of more than {_BRIDGED_S:g} s"
        raise refused(source, "", text)
    begin, end = motion.time_s[cut.rows][[0, -1]]
    steps = int(np.floor((end - begin) / _STEP_S + 1e-6))
    time_s: Floats = np.arange(steps + 1.0) * _STEP_S
    speed = _at(motion, motion.speed[:, cut.cars], begin + time_s)
    gap = _at(motion, motion.gap[:, cut.cars], begin + time_s)
    gap[:, 0] = np.nan
    return Convoy(
        name=name,
        cars=table.cars[cut.cars],
        time_s=time_s,
        speed=speed,
        gap=gap,
        setting=table.setting,
        told=_told(table, motion, cut),
    )


def _chosen(table: Table, choice: Choice, source: str) -> Table:
    """Return the table with the chosen cars and times only."""
    first_s, last_s = float(table.time_s[0]), float(table.time_s[-1])
    from_s = first_s if choice.from_s is None else choice.from_s
    to_s = last_s if choice.to_s is None else choice.to_s
    rows = (table.time_s >= from_s - _ROUNDING_S) & (table.time_s <= to_s + _ROUNDING_S)
    if rows.sum() < 2:
        text = f"{trimmed(from_s)} s to {trimmed(to_s)} s has no two rows of the file, which is "
        text += f"from {trimmed(first_s)} s to {trimmed(last_s)} s"
        raise ConvoyError([Problem(key="--from-s" if choice.from_s else "--to-s", text=text)])
    cars = range(len(table.cars)) if choice.cars is None else _indices(table, choice.cars, source)
    if len(cars) > _MOST_CARS:
        raise refused(source, "", f"{len(cars)} cars, more than the limit of {_MOST_CARS}")
    return table.of_cars(list(cars)).of_rows(rows)


def _indices(table: Table, wanted: tuple[str, ...], source: str) -> list[int]:
    """Return the indices of cars that are named, or given by their numbers in the file."""
    found = []
    for name in wanted:
        if name in table.cars:
            found.append(table.cars.index(name))
        elif name.isdecimal() and int(name) in table.numbers:
            found.append(table.numbers.index(int(name)))
        else:
            text = f"{shown(name)} is not a car of {source}; allowed: {listed(table.cars)}"
            raise ConvoyError([Problem(key="--cars", text=text)])
    if len(set(found)) < len(found):
        raise ConvoyError([Problem(key="--cars", text="a car is named twice")])
    return found


def _with_gaps(table: Table, choice: Choice, source: str) -> Table:
    """Return the table with gaps, from positions if need be; raises ConvoyError if one is below 0.

    The first car has none, nor a car whose predecessor in the file is not its predecessor here.
    """
    position, gap = table.position, table.gap
    columns, lines = table.gap_columns, table.gap_lines
    if gap is None:
        assert position is not None
        position = _bridged(table.time_s, position)
        gap = np.full(position.shape, np.nan)
        gap[:, 1:] = position[:, :-1] - position[:, 1:] - choice.length_m
        columns = tuple(f"positions of {one} and of the car ahead" for one in table.cars)
    else:
        gap = gap.copy()
        gap[:, 0] = np.nan
        gap[:, 1:][:, np.diff(table.numbers) != 1] = np.nan
    if choice.skip_negative_gaps:
        gap = np.where(gap < 0.0, np.nan, gap)
    assert lines is not None
    faults = Faults(source)
    for column, name in enumerate(columns):
        check_gaps(gap[:, column], lines[:, column].tolist(), name, faults)
    faults.refuse()
    return replace(table, position=position, gap=gap)


def _motion(table: Table) -> _Motion:
    """Return speeds, from positions if need be, and gaps, all with holes bridged."""
    time_s, speed, position, gap = table.time_s, table.speed, table.position, table.gap
    assert gap is not None
    if speed is None:
        assert position is not None
        speed = np.gradient(_bridged(time_s, position), time_s, axis=0)
    else:
        speed = _bridged(time_s, speed)
    return _Motion(time_s, np.asarray(speed), _bridged(time_s, gap))


def _bridged(time_s: Floats, values: Floats) -> Floats:
    """Return values (T, n) with lines across holes of up to a second; other holes stay."""
    filled = values.copy()
    for column in filled.T:
        known = np.flatnonzero(~np.isnan(column))
        if len(known) < 2:
            continue
        after = np.searchsorted(known, np.arange(len(column)))
        inside = (after > 0) & (after < len(known))
        span = time_s[known[after[inside]]] - time_s[known[after[inside] - 1]]
        short = np.flatnonzero(inside)[span <= _BRIDGED_S + _ROUNDING_S]
        column[short] = np.interp(time_s[short], time_s[known], column[known])
    return filled


def _longest(table: Table, motion: _Motion) -> _Cut | None:
    """Return the cars and rows with the most seconds of following; None if there are none."""
    best: _Cut | None = None
    count = len(table.cars)
    for first in range(count - 1):
        whole = np.isfinite(motion.speed[:, first])
        for last in range(first + 1, count):
            whole = whole & np.isfinite(motion.speed[:, last]) & np.isfinite(motion.gap[:, last])
            rows = _longest_run(motion.time_s, whole)
            if rows is None:
                break
            followed_s = float(np.ptp(motion.time_s[rows])) * (last - first)
            if best is None or followed_s > best.followed_s:
                best = _Cut(slice(first, last + 1), rows, followed_s)
    return best


def _longest_run(time_s: Floats, whole: Bools) -> slice | None:
    """Return the longest stretch of whole rows that are at most a second apart; None: none."""
    rows = np.flatnonzero(whole)
    if len(rows) < 2:
        return None
    ends = (np.diff(rows) > 1) | (np.diff(time_s[rows]) > _BRIDGED_S + _ROUNDING_S)
    begins = np.concatenate([[0], np.flatnonzero(ends) + 1])
    lasts = np.concatenate([np.flatnonzero(ends), [len(rows) - 1]])
    longest = int(np.argmax(time_s[rows[lasts]] - time_s[rows[begins]]))
    return slice(int(rows[begins[longest]]), int(rows[lasts[longest]]) + 1)


def _at(motion: _Motion, values: Floats, time_s: Floats) -> Floats:
    """Return values (T, n) at other times, on straight lines between rows."""
    return np.array([np.interp(time_s, motion.time_s, column) for column in values.T]).T


def _told(table: Table, motion: _Motion, cut: _Cut) -> dict[str, str]:
    """Return what was taken and what was left out, for people."""
    cars = table.cars[cut.cars]
    left = [name for name in table.cars if name not in cars]
    begin, end = motion.time_s[cut.rows][[0, -1]]
    first, last = table.time_s[[0, -1]]
    holes = sum(
        int(np.isnan(values[cut.rows, cut.cars][:, skipped:]).sum())
        for values, skipped in ((table.speed, 0), (table.position, 0), (table.gap, 1))
        if values is not None
    )
    return {
        "cars": ", ".join(cars),
        "cars left out": ", ".join(left) or "none",
        "from": f"{begin:g} s, of {first:g} s",
        "to": f"{end:g} s, of {last:g} s",
        "values bridged": str(holes),
    }
