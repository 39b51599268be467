"""Speed traces in CSV files: the points of events that name a file instead."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import replace
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

HEADER = ("time_s", "speed_mps")

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_HEADER = ",".join(HEADER)


def with_points(root: Node, origins: Mapping[str, Origin]) -> tuple[Node, list[Problem]]:
    """`root` with the contents of CSV files as the points of its traces, and what is wrong there.

    A file's name is relative to the file that says it, one of `origins` by what places call it;
    that of an option to the folder of the command.
    """
    events = root.child("events")
    if events is None or not isinstance(events.value, tuple):
        return root, []
    problems: list[Problem] = []
    items = []
    for index, event in enumerate(events.value):
        kind = event.child("type")
        if kind is None or kind.value != "trace" or not isinstance(event.value, dict):
            items.append(event)
            continue
        try:
            points = _points(event, f"events.{index}", origins)
        except ScenarioError as error:
            problems += error.problems
            points = Node(Unreadable.UNREADABLE, event.place)
        rest = {name: child for name, child in event.value.items() if name != "file"}
        items.append(replace(event, value={**rest, "points": points}))
    assert isinstance(root.value, dict)
    entries = {**root.value, "events": replace(events, value=tuple(items))}
    return replace(root, value=entries), problems


def _points(event: Node, key: str, origins: Mapping[str, Origin]) -> Node:
    """The points of a trace, as given or as read; raises ScenarioError."""
    file, points = event.child("file"), event.child("points")
    if file is None and points is None:
        raise _refused(key, "neither file nor points is given; allowed: one of both", event.place)
    if file is None or (points is not None and points.place.rank > file.place.rank):
        assert points is not None
        return points
    key = f"{key}.file"
    if points is not None and points.place.rank == file.place.rank:
        raise _refused(key, "given beside points; allowed: one of both", file.place)
    if file.value is Unreadable.UNREADABLE:
        return file
    if not isinstance(file.value, str):
        text = f"{shown(file.plain())} is not text, the name of a CSV file"
        raise _refused(key, text, file.place)
    origin = origins.get(file.place.source)
    beside = from_here(file.value) if origin is None else origin.beside(file.value)
    return _read(beside, key, file.place)


def _read(origin: Origin, key: str, named: Place) -> Node:
    """The points in a CSV file named at a place, each with its own; raises ScenarioError."""
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
    said = [(place, text) for row, place in rows for text in _of_row(row)]
    if texts := _of_header(header[0]):
        said.insert(0, (header[1], texts[0]))
    problems = [Problem(key=key, text=text, place=place) for place, text in said]
    if problems:
        raise InvalidScenarioError(problems)
    return Node(tuple(_point(row, place) for row, place in rows), top)


def _rows(text: str, top: Place) -> list[tuple[list[str], Place]]:
    """The rows with their places: the header, and what is not blank."""
    reader = csv.reader(StringIO(text.removeprefix("\ufeff"), newline=""))
    header = next(reader, [])
    rows = ((row, replace(top, line=reader.line_num)) for row in reader)
    return [(header, replace(top, line=1)), *((row, place) for row, place in rows if row)]


def _of_header(row: list[str]) -> list[str]:
    said = ",".join(cell.strip() for cell in row)
    return [] if said == _HEADER else [f"{shown(said)} is not the header {_HEADER}"]


def _of_row(row: list[str]) -> list[str]:
    if len(row) != len(HEADER):
        return [f"a row of {len(row)} is not a row of {len(HEADER)}, {_HEADER}"]
    return [
        f"{name}: {shown(cell)} is not a number"
        for name, cell in zip(HEADER, row, strict=True)
        if not _NUMBER.fullmatch(cell.strip())
    ]


def _point(row: list[str], place: Place) -> Node:
    return Node(tuple(Node(float(cell), place) for cell in row), place)


def _refused(key: str, text: str, place: Place) -> InvalidScenarioError:
    return InvalidScenarioError([Problem(key=key, text=text, place=place)])
