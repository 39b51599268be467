"""Reads tables of numbers from CSV files, which a scenario may name instead of a list."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import StringIO
from typing import Final, Protocol

from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    ScenarioError,
    UnreadableScenarioError,
)
from zenvoy.scenarios.reading.bounded import LARGEST_BYTES
from zenvoy.scenarios.reading.origin import Origin, origin_of
from zenvoy.scenarios.reading.tree import Node, Unreadable
from zenvoy.values.wording import shown

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)

_MOST_CHARACTERS: Final = 2 * LARGEST_BYTES


class Allowance:
    """A budget of text from tables: a scenario may name one file twenty thousand times."""

    def __init__(self) -> None:
        self._left = _MOST_CHARACTERS

    def take(self, characters: int) -> None:
        """Use up some of the budget; raises ValueError if it is exceeded."""
        self._left -= characters
        if self._left < 0:
            raise ValueError(f"more than {_MOST_CHARACTERS >> 20} MiB in all tables together")


class Reader(Protocol):
    """Reads the text of a file as a list."""

    @property
    def options(self) -> tuple[str, ...]:
        """The keys of a section that say how to read the file."""
        ...

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """Return the list in `text`, each entry with its place; `top` is that of the file.

        `key` is that of the section. Raises ScenarioError, or ValueError for another kind of file.
        """
        ...


@dataclass(frozen=True, slots=True)
class Table:
    """A list that a section has under `entry`, or in a `file`."""

    entry: str
    reader: Reader
    required: bool = True

    def filled(
        self, section: Node, key: str, origins: Mapping[str, Origin], allowance: Allowance
    ) -> tuple[Node, ScenarioError | None]:
        """Return the section with its list, as given or as read, and the error if there is one.

        A file name is relative to the file that contains it, which `origins` finds by the `source`
        of the place. In an option, it is relative to the current folder.
        """
        if not isinstance(section.value, dict):
            return section, None
        if not self.required and not {"file", self.entry} & section.value.keys():
            return section, None
        wrong: ScenarioError | None = None
        try:
            rows = self._rows_of(section, key, origins, allowance)
        except ScenarioError as error:
            wrong = error
            rows = Node(Unreadable.UNREADABLE, section.place)
        of_file = {"file", *self.reader.options}
        rest = {name: child for name, child in section.value.items() if name not in of_file}
        return replace(section, value={**rest, self.entry: rows}), wrong

    def _rows_of(
        self, section: Node, key: str, origins: Mapping[str, Origin], allowance: Allowance
    ) -> Node:
        """Return the list, as given or as read; raises ScenarioError."""
        file, given = section.child("file"), section.child(self.entry)
        options = {name: n for name in self.reader.options if (n := section.child(name))}
        if file is None and given is None:
            text = f"neither file nor {self.entry} is given; allowed: one of the two"
            raise _refused(key, text, section.place)
        if file is None or (given is not None and given.place.rank > file.place.rank):
            assert given is not None
            if file is None and options:
                name, node = next(iter(options.items()))
                raise _refused(f"{key}.{name}", "given without a file; allowed: none", node.place)
            return given
        if given is not None and given.place.rank == file.place.rank:
            text = f"given together with {self.entry}; allowed: one of the two"
            raise _refused(f"{key}.file", text, file.place)
        if file.value is Unreadable.UNREADABLE:
            return file
        if not isinstance(file.value, str):
            text = f"{shown(file.plain())} is not text, the name of a CSV file"
            raise _refused(f"{key}.file", text, file.place)
        origin = origin_of(file.value, file.place, origins)
        return self._read(origin, key, file.place, options, allowance)

    def _read(
        self,
        origin: Origin,
        key: str,
        named: Place,
        options: Mapping[str, Node],
        allowance: Allowance,
    ) -> Node:
        """Return the rows of the file that is named at a place; raises ScenarioError."""
        top = Place(source=origin.source, rank=named.rank)
        try:
            text = origin.text(named.rank)
            allowance.take(len(text))
            return self.reader.read(text, top, key, options)
        except UnreadableScenarioError as error:
            problems = [replace(problem, key=f"{key}.file") for problem in error.problems]
            raise InvalidScenarioError(problems) from None
        except (OSError, ValueError, csv.Error) as error:
            why = error.strerror if isinstance(error, OSError) else error
            text = f"{shown(origin.source)} cannot be read: {why}"
            raise _refused(f"{key}.file", text, named) from None


@dataclass(frozen=True, slots=True)
class Numbers:
    """Reads a CSV file with one column of numbers under a given header."""

    header: str

    @property
    def options(self) -> tuple[str, ...]:
        """There are no options."""
        return ()

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """Return the numbers; see `Reader`."""
        header, *rows = _rows(text, top)
        if ",".join(cell.strip() for cell in header[0]) != self.header:
            # It may be any file, so the message shows none of its text.
            what = f"not a table of numbers under the header {self.header}"
            raise _refused(f"{key}.file", what, header[1])
        problems = [
            Problem(key=f"{key}.file", text=text, place=place)
            for row, place in rows
            for text in self._faults(row)
        ]
        if problems:
            raise InvalidScenarioError(problems)
        return Node(tuple(Node(float(cell), place) for (cell,), place in rows), top)

    def _faults(self, row: list[str]) -> list[str]:
        if len(row) != 1:
            return [f"a row of {len(row)} is not a row of 1, {self.header}"]
        if not _NUMBER.fullmatch(row[0].strip()):
            return [f"{self.header}: {shown(row[0])} is not a number"]
        return []


def _rows(text: str, top: Place) -> list[tuple[list[str], Place]]:
    """Return the header and all rows that are not blank, with their places."""
    reader = csv.reader(StringIO(text.removeprefix("\ufeff"), newline=""))
    header = next(reader, [])
    rows = ((row, replace(top, line=reader.line_num)) for row in reader)
    return [(header, replace(top, line=1)), *((row, place) for row, place in rows if row)]


def _refused(key: str, text: str, place: Place) -> InvalidScenarioError:
    return InvalidScenarioError([Problem(key=key, text=text, place=place)])
