"""A scenario that says only what differs from another: the chain of files, and their merger."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from zenvoy.scenarios.errors import InvalidScenarioError, Place, Problem, UnreadableScenarioError
from zenvoy.scenarios.reading.allowed import schema_at
from zenvoy.scenarios.reading.origin import Origin
from zenvoy.scenarios.reading.source import parse
from zenvoy.scenarios.reading.tree import Node, Unreadable
from zenvoy.values.wording import kind_of, one_line, shown

KEY: Final = "extends"
_MOST: Final = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """A scenario and all that it extends, merged.

    text is the scenario's own; problems is what could not be read, in any of the files; origins
    has the files by what places call them.
    """

    text: str
    root: Node
    problems: list[Problem]
    origins: dict[str, Origin]


def chain(origin: Origin) -> Chain:
    """Read the scenario of `origin` and what it extends, each file's values over its base's.

    Mappings are merged key by key; lists and single values replace. Raises UnknownScenarioError,
    UnreadableScenarioError or InvalidScenarioError where there is no chain to the end.
    """
    origins: list[Origin] = []
    texts: list[str] = []
    roots: list[Node] = []
    problems: list[Problem] = []
    current: Origin | None = origin
    while current is not None:
        if len(origins) == _MOST:
            place = _place(origins[-1].source, 1 - _MOST, None)
            text = f"more than {_MOST} scenarios, each of which extends the next"
            raise InvalidScenarioError([Problem(key=KEY, text=text, place=place)])
        texts.append(_text(current, -len(origins)))
        root, found = _tree(texts[-1], partial(_place, current.source, -len(origins)))
        problems += found
        origins.append(current)
        root, current = _without_base(root, origins, problems)
        roots.append(root)
    merged = roots.pop()
    while roots:
        merged = _merged(merged, roots.pop())
    by_source = {origin.source: origin for origin in origins}
    return Chain(text=texts[0], root=merged, problems=problems, origins=by_source)


def _without_base(
    root: Node, origins: list[Origin], problems: list[Problem]
) -> tuple[Node, Origin | None]:
    """`root`, the tree of the last of `origins`, without its `extends`; and what that names."""
    assert isinstance(root.value, dict)
    said = root.value.get(KEY)
    if said is None:
        return root, None
    name = said.value
    if name is Unreadable.UNREADABLE:  # which is among the problems
        raise InvalidScenarioError(problems)
    if not isinstance(name, str) or not name:
        text = f"{shown(said.plain())} is not the name of a scenario: a file or a built-in one"
        raise InvalidScenarioError([*problems, Problem(key=KEY, text=text, place=said.place)])
    base = origins[-1].base(name, said.place)
    if base.identity in (identities := [origin.identity for origin in origins]):
        ring = origins[identities.index(base.identity) :]
        way = " → ".join(one_line(origin.source) for origin in (*ring, base))
        text = f"{shown(name)} closes a circle: {way}; allowed: a scenario that is not in it"
        raise InvalidScenarioError([*problems, Problem(key=KEY, text=text, place=said.place)])
    entries = {key: child for key, child in root.value.items() if key != KEY}
    return replace(root, value=entries), base


def _merged(base: Node, over: Node) -> Node:
    if not isinstance(base.value, dict) or not isinstance(over.value, dict):
        return over
    entries = {
        key: _merged(base.value[key], child) if key in base.value else child
        for key, child in over.value.items()
    }
    return replace(over, value={**base.value, **entries})


def _place(source: str, rank: int, line: int | None) -> Place:
    return Place(source=source, line=line, rank=rank)


def _text(origin: Origin, rank: int) -> str:
    try:
        return origin.text(rank)
    except (OSError, ValueError) as error:
        place = Place(source=origin.source, rank=rank)
        why = error.strerror if isinstance(error, OSError) else error
        problem = Problem(key="", text=f"cannot be read: {why}", place=place)
        raise UnreadableScenarioError([problem]) from error


def _tree(text: str, place_at: Callable[[int | None], Place]) -> tuple[Node, list[Problem]]:
    """The mapping that `text` is.

    A file that another one names may be any file that this command can read, and not its author:
    so nothing of its text is told before it looks like a scenario.
    """
    root, problems = parse(text, place_at, top_level=True)
    extended = place_at(None).rank < 0
    if root is None:
        what = "empty; allowed: a mapping ({} for the defaults alone)"
    elif not isinstance(root.value, dict):
        what = f"{kind_of(root.plain())} is not a mapping, as the top level has to be"
    elif extended and root.value and not root.value.keys() & schema_at(())["properties"].keys():
        what = "not a scenario: a mapping without a single key of one"
    else:
        return root, problems
    known = [] if extended else problems
    raise InvalidScenarioError([*known, Problem(key="", text=what, place=place_at(None))])
