"""Tables of numbers in CSV files that stand in place of a list in a scenario."""

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
    """How much text may still be read from tables: one file may be named twenty thousand times."""

    def __init__(self) -> None:
        self._left = _MOST_CHARACTERS

    def take(self, characters: int) -> None:
        """Raises ValueError where it is used up."""
        self._left -= characters
        if self._left < 0:
            raise ValueError(f"more than {_MOST_CHARACTERS >> 20} MiB in all tables together")


class Reader(Protocol):
    """Reads the text of a file as the list that it stands for."""

    @property
    def options(self) -> tuple[str, ...]:
        """What a section may say of the file, beside its name."""
        ...

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """The list in `text`, each entry with its place in the file, of which `top` is the whole.

        `key` is that of the section. Raises ScenarioError, or ValueError where it is no such file.
        """
        ...


@dataclass(frozen=True, slots=True)
class Table:
    """What a section may give as a list under `entry`, or in a `file`."""

    entry: str
    reader: Reader
    required: bool = True

    def filled(
        self, section: Node, key: str, origins: Mapping[str, Origin], allowance: Allowance
    ) -> tuple[Node, ScenarioError | None]:
        """The section with its list, as given or as read, and what is wrong there.

        A file's name is relative to the file that says it, one of `origins` by what places call
        it; that of an option to the folder of the command.
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
        """The list, as given or as read; raises ScenarioError."""
        file, given = section.child("file"), section.child(self.entry)
        options = {name: n for name in self.reader.options if (n := section.child(name))}
        if file is None and given is None:
            text = f"neither file nor {self.entry} is given; allowed: one of both"
            raise _refused(key, text, section.place)
        if file is None or (given is not None and given.place.rank > file.place.rank):
            assert given is not None
            if file is None and options:
                name, node = next(iter(options.items()))
                raise _refused(f"{key}.{name}", "given without a file; allowed: none", node.place)
            return given
        if given is not None and given.place.rank == file.place.rank:
            text = f"given beside {self.entry}; allowed: one of both"
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
        """The rows in a file named at a place, each with its own; raises ScenarioError."""
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
    """Reads a CSV file with just one column, of numbers, under a header that is given."""

    header: str

    @property
    def options(self) -> tuple[str, ...]:
        """None."""
        return ()

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """The numbers, as `Reader` has it."""
        header, *rows = _rows(text, top)
        if ",".join(cell.strip() for cell in header[0]) != self.header:
            # This may be any file: nothing of its text is told.
            what = f"not a table of numbers under the header {self.header}"
            raise _refused(f"{key}.file", what, header[1])
        said = [(place, found) for row, place in rows for found in self._of_row(row)]
        if said:
            raise InvalidScenarioError(
                Problem(key=f"{key}.file", text=found, place=place) for place, found in said
            )
        return Node(tuple(Node(float(cell), place) for (cell,), place in rows), top)

    def _of_row(self, row: list[str]) -> list[str]:
        if len(row) != 1:
            return [f"a row of {len(row)} is not a row of 1, {self.header}"]
        if not _NUMBER.fullmatch(row[0].strip()):
            return [f"{self.header}: {shown(row[0])} is not a number"]
        return []


def _rows(text: str, top: Place) -> list[tuple[list[str], Place]]:
    """The rows with their places: the header, and what is not blank."""
    reader = csv.reader(StringIO(text.removeprefix("\ufeff"), newline=""))
    header = next(reader, [])
    rows = ((row, replace(top, line=reader.line_num)) for row in reader)
    return [(header, replace(top, line=1)), *((row, place) for row, place in rows if row)]


def _refused(key: str, text: str, place: Place) -> InvalidScenarioError:
    return InvalidScenarioError([Problem(key=key, text=text, place=place)])
