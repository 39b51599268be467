"""Errors in a scenario: the exception tree, and the problems that an exception carries."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from zenvoy.values.wording import one_line

MOST_PROBLEMS: Final = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where a value was written: a line of a file, or an option of the command line.

    rank is the order in which values apply: 0 for the file, below 0 for the files that it extends,
    and 1, 2, … for options.
    """

    source: str
    line: int | None = None
    rank: int = 0

    def __str__(self) -> str:
        source = one_line(self.source)
        return source if self.line is None else f"{source}, line {self.line}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """One problem: its dotted key, a text that says what is allowed, and its place.

    key is empty if the problem concerns the whole file. related has the other keys involved.
    """

    key: str
    text: str
    place: Place | None = None
    related: tuple[str, ...] = ()

    def __str__(self) -> str:
        what = f"{self.key}: {self.text}" if self.key else self.text
        return what if self.place is None else f"{what}  ({self.place})"

    @property
    def order(self) -> tuple[int, str, int]:
        """Sort key: extended files first, then the file by line, then the options."""
        return order_of(self.place)


def order_of(place: Place | None) -> tuple[int, str, int]:
    """Return the sort key of a place."""
    return (0, "", 0) if place is None else (place.rank, place.source, place.line or 0)


class ScenarioError(Exception):
    """A scenario cannot be loaded. str() has one line per problem.

    Of many problems the first MOST_PROBLEMS are kept; `more` is the number of the others.
    """

    def __init__(self, problems: Iterable[Problem], more: int = 0) -> None:
        found = sorted(problems, key=lambda p: p.order)
        self.problems: tuple[Problem, ...] = tuple(found[:MOST_PROBLEMS])
        self.more = more + max(0, len(found) - MOST_PROBLEMS)
        super().__init__(self.problems, self.more)

    def __str__(self) -> str:
        lines = [str(problem) for problem in self.problems]
        return "\n".join([*lines, f"and {self.more} more"] if self.more else lines)


class UnknownScenarioError(ScenarioError):
    """The name is neither a file nor a built-in scenario."""


class UnreadableScenarioError(ScenarioError):
    """The file cannot be read, is not UTF-8 or is not YAML."""


class InvalidScenarioError(ScenarioError):
    """The YAML is valid, but the scenario is not: an unknown key, a wrong type, a bad value."""
