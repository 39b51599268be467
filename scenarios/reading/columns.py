"""Finds the columns of a table that hold times and speeds."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from zenvoy.scenarios.reading.grid import likely_header
from zenvoy.scenarios.schema.units import SPEEDS, TIMES, Ratio, split_header
from zenvoy.values.wording import listed, shown

# The name of a column of times or speeds has at least one of its words, and any of the qualifiers.
_TIME_WORDS: Final = frozenset({"time", "t", "timestamp", "timestep"})
_SPEED_WORDS: Final = frozenset({"speed", "v", "velocity"})
_QUALIFIERS: Final = frozenset(
    {"test", "target", "reference", "cycle", "cyc", "elapsed", "recorded", "sim", "simulation"}
    | {"gps", "vehicle", "veh", "lead", "leader", "actual", "schedule", "unix", "utc"}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What to read from a table; None: the table itself decides.

    Columns are given by name. `time` is "as-given" or "from-first". `where` maps columns to
    values: only rows with these values are read, such as those of one vehicle.
    """

    column: str | None = None
    time_column: str | None = None
    unit: str | None = None
    time_unit: str | None = None
    time: str | None = None
    where: Mapping[str, str] = field(default_factory=dict)


class RecordingError(Exception):
    """A table cannot be read. Each problem is a line (None: the whole table), a key and a text."""

    def __init__(self, problems: Iterable[tuple[int | None, str, str]]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(text for _, _, text in self.problems))


def columns_of(header: Sequence[str], choice: Choice) -> tuple[int, int] | None:
    """Return the indices of times and speeds; None if the header does not name one of each."""
    times = _matching(header, choice.time_column, TIMES, _TIME_WORDS)
    speeds = _matching(header, choice.column, SPEEDS, _SPEED_WORDS)
    if len(times) != 1 or len(speeds) != 1 or times == speeds:
        return None
    return times[0], speeds[0]


def _matching(
    header: Sequence[str], wanted: str | None, units: Mapping[str, Ratio], words: frozenset[str]
) -> list[int]:
    """Return the indices of the columns with the wanted name, or else with these words."""
    names = [(cell, *split_header(cell, units)) for cell in header]
    if wanted is None:
        return [
            index
            for index, (_, name, unit) in enumerate(names)
            if (found := _words(name)) <= words | _QUALIFIERS and (found & words or unit)
        ]
    wanted = wanted.strip()
    exact = [index for index, (cell, _, _) in enumerate(names) if cell == wanted]
    return exact or [index for index, (_, name, _) in enumerate(names) if name == wanted.lower()]


def _words(name: str) -> frozenset[str]:
    return frozenset(filter(None, re.split(r"[\W_]+", name)))


def no_header(text: str, choice: Choice) -> RecordingError:
    """Return an error that says which column is missing or ambiguous in the likeliest header."""
    likely = likely_header(text)
    if likely is None:
        what = "no line names a time and a speed, as the header time_s,speed_mps does"
        return RecordingError([(None, "", what)])
    line, header = likely
    names = [cell for cell in header if cell]
    problems = []
    for key, wanted, units, words, what in (
        ("time_column", choice.time_column, TIMES, _TIME_WORDS, "time"),
        ("column", choice.column, SPEEDS, _SPEED_WORDS, "speed"),
    ):
        count = len(_matching(header, wanted, units, words))
        allowed = f"allowed: one of {listed([n for n in names if what in n.lower()] or names)}"
        if wanted is not None and count != 1:
            how = "not a column" if count == 0 else f"the name of {count} columns"
            problems.append((line, key, f"{shown(wanted)} is {how}; {allowed}"))
        elif wanted is None and count > 1:
            text = f"not given, and {count} columns are called a {what}; {allowed}"
            problems.append((line, key, text))
        elif wanted is None and count == 0:
            problems.append((line, key, f"not given, and no column is called a {what}; {allowed}"))
    if not problems:
        name = shown(header[_matching(header, choice.column, SPEEDS, _SPEED_WORDS)[0]])
        problems.append((line, "column", f"{name} is also the column of times"))
    return RecordingError(problems)
