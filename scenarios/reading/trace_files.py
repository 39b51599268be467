"""Reads the points of a trace from a file, with the options of a scenario or the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    UnreadableScenarioError,
)
from zenvoy.scenarios.reading.columns import Choice, RecordingError
from zenvoy.scenarios.reading.origin import from_here
from zenvoy.scenarios.reading.recordings import Recording, recording
from zenvoy.scenarios.reading.tree import Node, Scalar
from zenvoy.scenarios.reading.validate import validated
from zenvoy.scenarios.schema.trace_options import READERS
from zenvoy.values.wording import shown


@dataclass(frozen=True, slots=True)
class TraceFile:
    """Reads a drive cycle or a recorded drive."""

    @property
    def options(self) -> tuple[str, ...]:
        """Keys of the options for reading the file."""
        return tuple(READERS)

    def read(self, text: str, top: Place, key: str, options: Mapping[str, Node]) -> Node:
        """Return points of [time_s, speed_mps]; see `Reader`."""
        values = {name: node.plain() for name, node in options.items()}
        places = {name: node.place for name, node in options.items()}
        read = _recording(text, top, f"{key}.", values, places)
        return _points(read, top)


def read_trace(path: Path, options: Mapping[str, object]) -> Recording:
    """Return the recording in a file, read and checked like a trace with these options.

    Raises InvalidScenarioError; the keys of its problems are names of options, "file" or "points".
    """
    top = Place(source=str(path))
    try:
        read = _recording(from_here(path).text(), top, "", options, {})
    except UnreadableScenarioError as error:
        raise InvalidScenarioError(replace(p, key="file") for p in error.problems) from None
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        text = f"{shown(str(path))} cannot be read: {why}"
        raise InvalidScenarioError([Problem(key="file", text=text)]) from None
    event: dict[str, Scalar] = {"type": "trace", "vehicle": 1, "at_s": 0.0}
    nodes = {name: Node(value, top) for name, value in event.items()}
    root = Node({"events": Node((Node({**nodes, "points": _points(read, top)}, top),), top)}, top)
    try:
        validated(root)
    except InvalidScenarioError as error:
        raise InvalidScenarioError(replace(p, key="points") for p in error.problems) from None
    return read


def _recording(
    text: str,
    top: Place,
    prefix: str,
    options: Mapping[str, object],
    places: Mapping[str, Place],
) -> Recording:
    """Return the recording in the text of a file.

    Raises InvalidScenarioError with all problems of the options, or else of the text. Their keys
    have the prefix; `places` has the places of the options, if any.
    """
    choice, problems = {}, []
    for name, value in options.items():
        try:
            choice[name] = READERS[name](value)
        except ValueError as error:
            place = places.get(name)
            problems.append(Problem(key=f"{prefix}{name}", text=str(error), place=place))
    if problems:
        raise InvalidScenarioError(problems)
    try:
        return recording(text, Choice(**choice))
    except RecordingError as error:
        raise InvalidScenarioError(
            Problem(
                key=f"{prefix}{name or 'file'}",
                text=found,
                place=places.get(name, replace(top, line=line)),
            )
            for line, name, found in error.problems
        ) from None


def _points(read: Recording, top: Place) -> Node:
    points = []
    for (time_s, speed_mps), line in zip(read.points, read.lines, strict=True):
        place = replace(top, line=line)
        points.append(Node((Node(time_s, place), Node(speed_mps, place)), place))
    return Node(tuple(points), top)
