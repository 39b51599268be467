"""Tables of numbers in CSV files that stand in place of a list in a scenario."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from io import StringIO

from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    ScenarioError,
    UnreadableScenarioError,
)
from zenvoy.scenarios.origin import Origin, from_here
from zenvoy.scenarios.tree import Node, Unreadable
from zenvoy.scenarios.wording import shown

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Table:
    """What a section may give as a list under `entry`, or as a CSV `file` with this header.

    Rows of one column become numbers, of more become lists of numbers.
    """

    entry: str
    header: tuple[str, ...]
    required: bool = True

    def filled(
        self, section: Node, key: str, origins: Mapping[str, Origin]
    ) -> tuple[Node, list[Problem]]:
        """The section with its list, as given or as read, and what is wrong there.

        A file's name is relative to the file that says it, one of `origins` by what places call
        it; that of an option to the folder of the command.
        """
        if not isinstance(section.value, dict):
            return section, []
        if not self.required and not {"file", self.entry} & section.value.keys():
            return section, []
        problems: list[Problem] = []
        try:
            rows = self._rows_of(section, key, origins)
        except ScenarioError as error:
            problems += error.problems
            rows = Node(Unreadable.UNREADABLE, section.place)
        rest = {name: child for name, child in section.value.items() if name != "file"}
        return replace(section, value={**rest, self.entry: rows}), problems

    def _rows_of(self, section: Node, key: str, origins: Mapping[str, Origin]) -> Node:
        """The list, as given or as read; raises ScenarioError."""
        file, given = section.child("file"), section.child(self.entry)
        if file is None and given is None:
            text = f"neither file nor {self.entry} is given; allowed: one of both"
            raise _refused(key, text, section.place)
        if file is None or (given is not None and given.place.rank > file.place.rank):
            assert given is not None
            return given
        key = f"{key}.file"
        if given is not None and given.place.rank == file.place.rank:
            raise _refused(key, f"given beside {self.entry}; allowed: one of both", file.place)
        if file.value is Unreadable.UNREADABLE:
            return file
        if not isinstance(file.value, str):
            text = f"{shown(file.plain())} is not text, the name of a CSV file"
            raise _refused(key, text, file.place)
        origin = origins.get(file.place.source)
        beside = from_here(file.value) if origin is None else origin.beside(file.value)
        return self._read(beside, key, file.place)

    def _read(self, origin: Origin, key: str, named: Place) -> Node:
        """The rows in a CSV file named at a place, each with its own; raises ScenarioError."""
        top = Place(source=origin.source, rank=named.rank)
        try:
            header, *rows = _rows(origin.text(named.rank), top)
        except UnreadableScenarioError as error:
            raise InvalidScenarioError(
                replace(problem, key=key) for problem in error.problems
            ) from None
        except (OSError, ValueError, csv.Error) as error:
            why = error.strerror if isinstance(error, OSError) else error
            text = f"{shown(origin.source)} cannot be read: {why}"
            raise _refused(key, text, named) from None
        said = [(place, text) for row, place in rows for text in self._of_row(row)]
        if texts := self._of_header(header[0]):
            said.insert(0, (header[1], texts[0]))
        problems = [Problem(key=key, text=text, place=place) for place, text in said]
        if problems:
            raise InvalidScenarioError(problems)
        return Node(tuple(_numbers(row, place) for row, place in rows), top)

    def _of_header(self, row: list[str]) -> list[str]:
        said, header = ",".join(cell.strip() for cell in row), ",".join(self.header)
        return [] if said == header else [f"{shown(said)} is not the header {header}"]

    def _of_row(self, row: list[str]) -> list[str]:
        width = len(self.header)
        if len(row) != width:
            return [f"a row of {len(row)} is not a row of {width}, {','.join(self.header)}"]
        return [
            f"{name}: {shown(cell)} is not a number"
            for name, cell in zip(self.header, row, strict=True)
            if not _NUMBER.fullmatch(cell.strip())
        ]


def _rows(text: str, top: Place) -> list[tuple[list[str], Place]]:
    """The rows with their places: the header, and what is not blank."""
    reader = csv.reader(StringIO(text.removeprefix("\ufeff"), newline=""))
    header = next(reader, [])
    rows = ((row, replace(top, line=reader.line_num)) for row in reader)
    return [(header, replace(top, line=1)), *((row, place) for row, place in rows if row)]


def _numbers(row: list[str], place: Place) -> Node:
    cells = tuple(Node(float(cell), place) for cell in row)
    return cells[0] if len(cells) == 1 else Node(cells, place)


def _refused(key: str, text: str, place: Place) -> InvalidScenarioError:
    return InvalidScenarioError([Problem(key=key, text=text, place=place)])
