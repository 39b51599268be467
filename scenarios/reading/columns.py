"""Which columns of a table hold times and speeds."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from zenvoy.scenarios.reading.grid import likely_header
from zenvoy.scenarios.schema.units import SPEEDS, TIMES, Ratio, split_header
from zenvoy.values.wording import listed, shown

# Words of which the name of a column of times, or of speeds, may consist: one of these at least,
# and any of those beside them.
_OF_TIMES: Final = frozenset({"time", "t", "timestamp", "timestep"})
_OF_SPEEDS: Final = frozenset({"speed", "v", "velocity"})
_BESIDE: Final = frozenset(
    {"test", "target", "reference", "cycle", "cyc", "elapsed", "recorded", "sim", "simulation"}
    | {"gps", "vehicle", "veh", "lead", "leader", "actual", "schedule", "unix", "utc"}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What to read of a table; None: as the table itself says.

    Columns are given by name. `time` is "as-given" or "from-first"; `where` gives for columns the
    only values that count, so that of a table of many vehicles the rows of one are read.
    """

    column: str | None = None
    time_column: str | None = None
    unit: str | None = None
    time_unit: str | None = None
    time: str | None = None
    where: Mapping[str, str] = field(default_factory=dict)


class RecordingError(Exception):
    """A table cannot be read: what is wrong, each with its line (None: the whole) and its key."""

    def __init__(self, problems: Iterable[tuple[int | None, str, str]]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(text for _, _, text in self.problems))


def columns_of(header: Sequence[str], choice: Choice) -> tuple[int, int] | None:
    """Where times and speeds are; None where the header does not name just one of each."""
    times = _matching(header, choice.time_column, TIMES, _OF_TIMES)
    speeds = _matching(header, choice.column, SPEEDS, _OF_SPEEDS)
    if len(times) != 1 or len(speeds) != 1 or times == speeds:
        return None
    return times[0], speeds[0]


def _matching(
    header: Sequence[str], wanted: str | None, units: Mapping[str, Ratio], words: frozenset[str]
) -> list[int]:
    """Indices of the columns of that name, whole or without its unit, else of those words."""
    names = [(cell, *split_header(cell, units)) for cell in header]
    if wanted is None:
        return [
            index
            for index, (_, name, unit) in enumerate(names)
            if (said := _words(name)) <= words | _BESIDE and (said & words or unit)
        ]
    wanted = wanted.strip()
    exact = [index for index, (cell, _, _) in enumerate(names) if cell == wanted]
    return exact or [index for index, (_, name, _) in enumerate(names) if name == wanted.lower()]


def _words(name: str) -> frozenset[str]:
    return frozenset(filter(None, re.split(r"[\W_]+", name)))


def no_header(text: str, choice: Choice) -> RecordingError:
    """Which of the columns there is not, or is more than once, in what looks like the header."""
    likely = likely_header(text)
    if likely is None:
        what = "no line names a time and a speed, as the header time_s,speed_mps does"
        return RecordingError([(None, "", what)])
    line, header = likely
    names = [cell for cell in header if cell]
    problems = []
    for key, wanted, units, words, what in (
        ("time_column", choice.time_column, TIMES, _OF_TIMES, "time"),
        ("column", choice.column, SPEEDS, _OF_SPEEDS, "speed"),
    ):
        count = len(_matching(header, wanted, units, words))
        allowed = f"allowed: one of {listed([n for n in names if what in n.lower()] or names)}"
        if wanted is not None and count != 1:
            how = "no column" if count == 0 else f"the name of {count} columns"
            problems.append((line, key, f"{shown(wanted)} is {how}; {allowed}"))
        elif wanted is None and count > 1:
            problems.append((line, key, f"not given, and {count} columns are a {what}; {allowed}"))
        elif wanted is None and count == 0:
            problems.append((line, key, f"not given, and no column is just a {what}; {allowed}"))
    if not problems:
        name = shown(header[_matching(header, choice.column, SPEEDS, _OF_SPEEDS)[0]])
        problems.append((line, "column", f"{name} is the column of times too"))
    return RecordingError(problems)
