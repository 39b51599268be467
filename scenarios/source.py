"""YAML 1.2 text as a tree of values with their places."""

from __future__ import annotations

import warnings
from collections.abc import Callable

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, ReusedAnchorWarning, YAMLError
from ruamel.yaml.nodes import MappingNode, SequenceNode
from ruamel.yaml.nodes import Node as YamlNode
from ruamel.yaml.reader import ReaderError

from zenvoy.scenarios import scalars
from zenvoy.scenarios.errors import Place, Problem, UnreadableScenarioError
from zenvoy.scenarios.tree import Node, Path, Unreadable
from zenvoy.scenarios.wording import dotted, one_line

PlaceAt = Callable[[int | None], Place]

# No setting lies deeper than a few levels; aliases can make any file infinitely deep.
DEEPEST = 50
# Aliases count as often as they are used, or a few lines could stand for billions of values.
_MOST_VALUES = 200_000


def parse(text: str, place_at: PlaceAt, path: Path = ()) -> tuple[Node | None, list[Problem]]:
    """The tree of `text`, None if it is empty, and what is wrong with single values of it.

    place_at turns a line, counted from 1, into a place; `path` leads to the value that `text`
    stands for. Raises UnreadableScenarioError if `text` is no YAML document at all.
    """
    builder = _Builder(place_at)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ReusedAnchorWarning)
            root = YAML(typ="safe", pure=True).compose(text)
        return (root and builder.node(root, path, place_at(None))), builder.problems
    except YAMLError as error:
        raise UnreadableScenarioError([_syntax_problem(error, text, place_at)]) from None
    except RecursionError:
        raise _too_much("levels", DEEPEST, place_at(None)) from None


def _too_much(what: str, most: int, place: Place) -> UnreadableScenarioError:
    text = f"more than {most} {what}, the most that are allowed"
    return UnreadableScenarioError([Problem(key="", text=text, place=place)])


def _syntax_problem(error: YAMLError, text: str, place_at: PlaceAt) -> Problem:
    line, what = None, str(error)
    if isinstance(error, MarkedYAMLError):
        what = ", ".join(filter(None, (error.context, error.problem)))
        line = error.problem_mark.line + 1 if error.problem_mark else None
    elif isinstance(error, ReaderError):
        what = f"U+{error.character:04X} is not a printable character"
        line = text.count("\n", 0, error.position) + 1
    return Problem(key="", text=f"not valid YAML: {one_line(what)}", place=place_at(line))


class _Builder:
    """Turns YAML nodes into ours, and collects what is wrong on the way."""

    def __init__(self, place_at: PlaceAt) -> None:
        self.problems: list[Problem] = []
        self._place_at = place_at
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
        for key_node, value in source.value:
            place = self._place(key_node)
            try:
                key = _key(key_node)
            except ValueError as error:
                self._refuse(path, str(error), place)
                continue
            if key in entries:
                first = f"first in {entries[key].place}"
                self._refuse((*path, key), f"given twice, {first}; allowed: once", place)
            else:
                entries[key] = self.node(value, (*path, key), place)
        return entries

    def _place(self, node: YamlNode) -> Place:
        return self._place_at(node.start_mark.line + 1)

    def _refuse(self, path: Path, text: str, place: Place) -> None:
        self.problems.append(Problem(key=dotted(path), text=text, place=place))


def _key(node: YamlNode) -> str:
    """The key as written (1 and true are the texts "1" and "true"), or ValueError."""
    if isinstance(node.value, str):
        return scalars.text(node.value)
    raise ValueError("a key is a list or a mapping; allowed: a text")
