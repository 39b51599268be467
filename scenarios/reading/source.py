"""Parses YAML 1.2 into a tree of values with their places."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from typing import Any, Final

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, ReusedAnchorWarning, YAMLError
from ruamel.yaml.nodes import MappingNode, SequenceNode
from ruamel.yaml.nodes import Node as YamlNode
from ruamel.yaml.reader import ReaderError

from zenvoy.scenarios.errors import Place, Problem, UnreadableScenarioError
from zenvoy.scenarios.reading import scalars
from zenvoy.scenarios.reading.tree import Node, Path, Unreadable
from zenvoy.values.wording import dotted, one_line

PlaceAt = Callable[[int | None], Place]

# Settings are at most a few levels deep, but aliases can make a file infinitely deep.
DEEPEST = 50
# Every use of an alias counts, because a few lines with aliases can expand to billions of values.
_MOST_VALUES = 200_000

_MERGE: Final = "tag:yaml.org,2002:merge"
# Prefix of the user's own keys at the top level, which may hold anchors.
_OWN_KEY: Final = "x-"
_QUOTED: Final = re.compile(r"""\"[^\"]*\"|'[^']*'""")


def parse(
    text: str, place_at: PlaceAt, path: Path = (), *, top_level: bool = False
) -> tuple[Node | None, list[Problem]]:
    """Return the tree of `text`, None if it is empty, and the problems with single values.

    place_at turns a line, counted from 1, into a place; `path` is that of the value in `text`. At
    the `top_level`, keys that begin with x- are left out. Raises UnreadableScenarioError if `text`
    is not a YAML document.
    """
    builder = _Builder(place_at, top_level)
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _CountingComposer
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ReusedAnchorWarning)
            root = yaml.compose(text)
        return (root and builder.node(root, path, place_at(None))), builder.problems
    except _TooManyNodesError:
        raise _too_much("values", _MOST_VALUES, place_at(None)) from None
    except YAMLError as error:
        raise UnreadableScenarioError([_syntax_problem(error, text, place_at)]) from None
    except RecursionError:
        raise _too_much("levels", DEEPEST, place_at(None)) from None


def _too_much(what: str, most: int, place: Place) -> UnreadableScenarioError:
    text = f"more than the limit of {most} {what}"
    return UnreadableScenarioError([Problem(key="", text=text, place=place)])


def _syntax_problem(error: YAMLError, text: str, place_at: PlaceAt) -> Problem:
    line, what = None, str(error)
    if isinstance(error, MarkedYAMLError):
        what = ", ".join(filter(None, (error.context, error.problem)))
        if place_at(None).rank < 0:  # it may be any file, so show none of its text
            what = _QUOTED.sub(lambda quoted: quoted[0] if _is_syntax(quoted[0]) else "…", what)
        line = error.problem_mark.line + 1 if error.problem_mark else None
    elif isinstance(error, ReaderError):
        what = f"U+{error.character:04X} is not a printable character"
        line = text.count("\n", 0, error.position) + 1
    return Problem(key="", text=f"not valid YAML: {one_line(what)}", place=place_at(line))


def _is_syntax(quoted: str) -> bool:
    """Return whether a quotation is a sign or a token such as <stream end>, not text."""
    return len(quoted) == 3 or quoted[1] == "<"


class _TooManyNodesError(Exception):
    """A document has more nodes than the limits on values and keys allow."""


class _CountingComposer(Composer):
    """Stops at the limit of nodes: reading ten million values would take minutes."""

    _nodes = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self._nodes += 1
        if self._nodes > 2 * _MOST_VALUES + 1:
            raise _TooManyNodesError
        return super().compose_node(parent, index)


class _Builder:
    """Turns YAML nodes into nodes with places, and collects the problems."""

    def __init__(self, place_at: PlaceAt, top_level: bool) -> None:
        self.problems: list[Problem] = []
        self._place_at = place_at
        self._top_level = top_level
        self._values = 0

    def node(self, source: YamlNode, path: Path, place: Place) -> Node:
        self._values += 1
        if self._values > _MOST_VALUES:
            raise _too_much("values", _MOST_VALUES, place)
        if len(path) > DEEPEST:
            raise _too_much("levels", DEEPEST, place)
        if isinstance(source, MappingNode) and source.tag == "tag:yaml.org,2002:map":
            return Node(self._entries(source, path), place)
        if isinstance(source, SequenceNode) and source.tag == "tag:yaml.org,2002:seq":
            items = enumerate(source.value)
            return Node(tuple(self.node(v, (*path, i), self._place(v)) for i, v in items), place)
        try:
            return Node(scalars.scalar(source), place)
        except ValueError as error:
            self._refuse(path, str(error), place)
            return Node(Unreadable.UNREADABLE, place)

    def _entries(self, source: MappingNode, path: Path) -> dict[str, Node]:
        entries: dict[str, Node] = {}
        merged: dict[str, Node] = {}
        merges: list[Place] = []
        for key_node, value in source.value:
            place = self._place(key_node)
            try:
                key = _key(key_node)
            except ValueError as error:
                self._refuse(path, str(error), place)
                continue
            is_merge = str(key_node.tag) == _MERGE
            first = merges[0] if is_merge and merges else None
            if not is_merge and key in entries:
                first = entries[key].place
            if first is not None:
                text = f"given twice, first in {first}; allowed: once"
                self._refuse((*path, key), text, place)
            elif is_merge:
                merges.append(place)
                merged = self._merged(value, (*path, key), place)
            elif not (self._top_level and not path and key.startswith(_OWN_KEY)):
                entries[key] = self.node(value, (*path, key), place)
        return merged | entries

    def _merged(self, source: YamlNode, path: Path, place: Place) -> dict[str, Node]:
        """Return the entries that `<<` merges in: of several mappings, the first has priority."""
        is_list = isinstance(source, SequenceNode)
        mappings = source.value if is_list else [source]
        if not all(isinstance(mapping, MappingNode) for mapping in mappings):
            text = "neither a mapping nor a list of mappings; << merges nothing else"
            self._refuse(path, text, place)
            return {}
        entries: dict[str, Node] = {}
        for mapping in mappings:
            # `path` grows although the keys are no deeper, because a mapping may merge itself.
            node = self.node(mapping, path, place)
            entries = (node.value if isinstance(node.value, dict) else {}) | entries
        return entries

    def _place(self, node: YamlNode) -> Place:
        return self._place_at(node.start_mark.line + 1)

    def _refuse(self, path: Path, text: str, place: Place) -> None:
        self.problems.append(Problem(key=dotted(path), text=text, place=place))


def _key(node: YamlNode) -> str:
    """Return a key as text (1 and true are "1" and "true"); raises ValueError."""
    if isinstance(node.value, str):
        return scalars.text(node.value)
    raise ValueError("a key is a list or a mapping; allowed: text")
