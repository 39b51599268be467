"""Reads a technology from a user's own YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    UnreadableScenarioError,
)
from zenvoy.scenarios.reading.origin import Origin, from_here, origin_of
from zenvoy.scenarios.reading.source import parse
from zenvoy.scenarios.reading.tree import Node, planted
from zenvoy.scenarios.reading.validate import validated
from zenvoy.scenarios.schema.technology import Technology
from zenvoy.values.wording import dotted, shown

_PATH: Final = ("channel", "technology")
_KEY: Final = dotted(_PATH)
_SUFFIXES: Final = (".yaml", ".yml")


def technology_in(path: str) -> Technology:
    """Return the technology in a file; raises ScenarioError."""
    place = Place(source=path)
    tree = _tree(from_here(path), path, place)
    return validated(planted(Node({}, place), _PATH, tree)).channel.technology


def with_technology(named: Node, origins: Mapping[str, Origin]) -> Node:
    """Return the values of a technology that is named by its file, and any other node as it is.

    Text with a slash, or with the suffix of a YAML file, names a file. Raises ScenarioError.
    """
    name = named.value
    if not isinstance(name, str) or not ("/" in name or name.endswith(_SUFFIXES)):
        return named
    return _tree(origin_of(name, named.place, origins), name, named.place)


def _tree(origin: Origin, reference: str, place: Place) -> Node:
    """Return the values in the file that a reference at a place names; raises ScenarioError."""
    rank = place.rank - 1  # it applies before the file that names it, like an extended scenario

    def place_at(line: int | None) -> Place:
        return Place(source=origin.source, line=line, rank=rank)

    try:
        root, problems = parse(origin.text(rank), place_at, _PATH)
    except UnreadableScenarioError as error:
        problems = [replace(problem, key=_KEY) for problem in error.problems]
        raise InvalidScenarioError(problems) from None
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        text = f"{shown(reference)} cannot be read: {why}"
        raise InvalidScenarioError([Problem(key=_KEY, text=text, place=place)]) from None
    keys = Technology.model_fields
    # A scenario can name any file that this command can read but its author cannot. So no message
    # shows text of the file unless it looks like a technology.
    if root is None or not isinstance(root.value, dict) or not root.value.keys() & keys.keys():
        text = f"not a technology, which is a mapping with keys of {', '.join(keys)}"
        raise InvalidScenarioError([Problem(key=_KEY, text=text, place=place_at(None))])
    if problems:
        raise InvalidScenarioError(problems)
    return replace(root, value={"name": Node(origin.name, root.place), **root.value})
