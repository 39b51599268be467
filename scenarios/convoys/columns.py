"""The columns of a recorded table, as the user names them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from zenvoy.scenarios.convoys.errors import ConvoyError, refused
from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.reading.grid import Row, likely_header
from zenvoy.scenarios.schema.units import SPEEDS, TIMES, Ratio, split_header, unit_named
from zenvoy.values.wording import listed, shown

CAR: Final = "{}"
"""What stands for the name of a car in the name of a column."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of a table; in `speed`, `position` and `gap`, {} stands for the name of a car.

    If vehicle names a column, the table has a row for each car and time, and no name has {}. Units
    are those of the schema; None: as the header says. Times without a unit are in s.
    """

    time: str
    speed: str | None = None
    position: str | None = None
    gap: str | None = None
    vehicle: str | None = None
    time_unit: str | None = None
    unit: str | None = None

    def __post_init__(self) -> None:
        """Raise ConvoyError if the columns do not make a convoy."""
        for option, unit, units in (
            ("unit", self.unit, SPEEDS),
            ("time-unit", self.time_unit, TIMES),
        ):
            if unit is not None and unit_named(unit, units) is None:
                raise _option(option, f"{shown(unit)} is not one of {', '.join(units)}")
        if self.position is None and self.gap is None:
            raise _option("gap", "not given, nor is a position; allowed: one of the two, or both")
        if self.position is None and self.speed is None:
            raise _option("speed", "not given, nor is a position; allowed: one of the two, or both")
        if self.speed is not None and self._speed_unit() is None:
            text = f"not given, and {shown(self.speed)} names no unit; "
            raise _option("unit", f"{text}allowed: one of {', '.join(SPEEDS)}")
        for option, name in self.motion.items():
            if self.vehicle is None and name.count(CAR) != 1:
                text = f"{shown(name)} has not one {CAR}, which stands for the name of a car; "
                text += f"allowed: such as {option}{CAR}, or the column of cars, with a vehicle"
                raise _option(option, text)
            if self.vehicle is not None and CAR in name:
                raise _option(option, f"{shown(name)} has a {CAR}, but a vehicle is given")

    @property
    def motion(self) -> dict[str, str]:
        """The columns of motion that are named, by option."""
        of = {"speed": self.speed, "position": self.position, "gap": self.gap}
        return {option: name for option, name in of.items() if name is not None}

    def cars_of(self, option: str, header: Sequence[str]) -> list[tuple[str, int]]:
        """Return the cars that have such a column, each with the index of it, in their order."""
        pattern = re.escape(self.motion[option]).replace(re.escape(CAR), "(.+)")
        found = ((re.fullmatch(pattern, cell), index) for index, cell in enumerate(header))
        return [(match[1], index) for match, index in found if match is not None]

    def missing_in(self, header: Row) -> list[tuple[str, str]]:
        """Return the options, and the names, that a header has no column for."""
        whole = {"time": self.time} | ({} if self.vehicle is None else {"vehicle": self.vehicle})
        if self.vehicle is not None:
            whole |= self.motion
        missing = [(option, name) for option, name in whole.items() if name not in header]
        if self.vehicle is None:
            missing += [one for one in self.motion.items() if not self.cars_of(one[0], header)]
        return missing

    def time_ratio(self) -> Ratio:
        """Return the ratio of the unit of times."""
        return TIMES[_unit(self.time_unit, self.time, TIMES) or "s"]

    def speed_ratio(self) -> Ratio:
        """Return the ratio of the unit of speeds."""
        return SPEEDS[self._speed_unit() or "m/s"]

    def _speed_unit(self) -> str | None:
        return _unit(self.unit, (self.speed or "").replace(CAR, ""), SPEEDS)


def _unit(given: str | None, header: str, units: Mapping[str, Ratio]) -> str | None:
    return split_header(header, units)[1] if given is None else unit_named(given, units)


def no_header(text: str, source: str, columns: Columns) -> ConvoyError:
    """Return an error that says which columns the likeliest header does not have."""
    likely = likely_header(text)
    if likely is None:
        what = "no line is a header of columns" if text.strip() else "empty"
        return refused(source, "", what)
    line, header = likely
    names = listed([cell for cell in header if cell])
    option, name = columns.missing_in(header)[0]
    how = "is the name of no column" if CAR in name else "is not a column"
    return refused(source, f"--{option}", f"{shown(name)} {how}; allowed: of {names}", line)


def _option(option: str, text: str) -> ConvoyError:
    return ConvoyError([Problem(key=f"--{option}", text=text)])
