"""Problems of a recorded table, which are gathered by column so that each is one line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from zenvoy.scenarios.errors import InvalidScenarioError, Place, Problem


class ConvoyError(InvalidScenarioError):
    """A recorded table cannot be read as a convoy; a line for each kind of fault and column.

    The keys of its problems are columns of the table, or options of the command line.
    """


@dataclass(slots=True)
class Faults:
    """The faults of a table; for each kind and column it reports the first one and the count."""

    source: str
    _first: dict[tuple[str, str], Problem] = field(default_factory=dict)
    _count: dict[tuple[str, str], int] = field(default_factory=dict)

    def add(self, column: str, kind: str, text: str, line: int | None = None) -> None:
        """Add a fault of a kind in a column, "" for the whole table."""
        place = Place(source=self.source, line=line)
        problem = Problem(key=column, text=text, place=place)
        self._first.setdefault((column, kind), problem)
        self._count[column, kind] = self._count.get((column, kind), 0) + 1

    def refuse(self) -> None:
        """Raise ConvoyError if there are faults."""
        if self._first:
            raise ConvoyError(self._told())

    def _told(self) -> Iterable[Problem]:
        for which, problem in self._first.items():
            more = self._count[which] - 1
            rows = f"; {more} more like it" if more else ""
            yield replace(problem, text=f"{problem.text}{rows}")


def refused(source: str, column: str, text: str, line: int | None = None) -> ConvoyError:
    """Return an error with a single fault."""
    return ConvoyError([Problem(key=column, text=text, place=Place(source=source, line=line))])
