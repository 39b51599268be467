"""A tree of the values of a scenario file, each with the place where it was written."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

from zenvoy.scenarios.errors import InvalidScenarioError, Place, Problem
from zenvoy.values.wording import dotted, shown

Path = tuple[str | int, ...]


class Unreadable(Enum):
    """Replaces a value that could not be read; the problem is reported already."""

    UNREADABLE = "unreadable"


Scalar = str | int | float | bool | Unreadable | None


@dataclass(frozen=True, slots=True)
class Node:
    """A value and its place. Mappings and lists hold nodes."""

    value: dict[str, Node] | tuple[Node, ...] | Scalar
    place: Place

    def plain(self) -> object:
        """Return the value without places: a dict, a list or a Scalar."""
        match self.value:
            case dict() as entries:
                return {key: child.plain() for key, child in entries.items()}
            case tuple() as items:
                return [child.plain() for child in items]
            case scalar:
                return scalar

    def child(self, step: str | int) -> Node | None:
        """Return the entry of a mapping by key or of a list by index; None if there is none."""
        if isinstance(self.value, dict):
            return self.value.get(str(step))
        if isinstance(self.value, tuple) and str(step).isdecimal() and int(step) < len(self.value):
            return self.value[int(step)]
        return None

    def find(self, path: Iterable[str | int]) -> Node | None:
        """Return the node at `path`; None if there is none."""
        node: Node | None = self
        for step in path:
            node = node.child(step) if node else None
        return node

    def place_of(self, path: Iterable[str | int]) -> Place:
        """Return the place of the last node along `path` that exists."""
        node = self
        for step in path:
            child = node.child(step)
            if child is None:
                break
            node = child
        return node.place


def planted(root: Node, path: tuple[str, ...], new: Node) -> Node:
    """Return `root` with `new` at `path`.

    Missing mappings are made, and the index after the last adds an entry to a list. Raises
    InvalidScenarioError if the path leads through a value that is neither a mapping nor a list.
    """
    return _planted(root, (), path, new)


def _planted(node: Node | None, done: tuple[str, ...], ahead: tuple[str, ...], new: Node) -> Node:
    if not ahead:
        return new
    step, rest = ahead[0], ahead[1:]
    if node is None:
        node = Node(() if step == "0" else {}, new.place)
    match node.value:
        case dict() as entries:
            child = _planted(entries.get(step), (*done, step), rest, new)
            return replace(node, value={**entries, step: child})
        case tuple() as items if step in map(str, range(len(items) + 1)):
            index = int(step)
            child = _planted(node.child(index), (*done, step), rest, new)
            return replace(node, value=(*items[:index], child, *items[index + 1 :]))
        case tuple() as items:
            choice = f"0 to {len(items)}" if items else "0"
            text = f"no such entry; allowed: {choice} ({len(items)} adds one)"
        case _:
            value = shown(node.plain())
            text = f"cannot be set; {dotted(done)} is {value}, neither a mapping nor a list"
    raise InvalidScenarioError([Problem(key=dotted((*done, step)), text=text, place=new.place)])
