"""Reads a scenario and the scenarios that it extends, and merges them."""

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
_MOST_SCENARIOS: Final = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """A scenario merged with all scenarios that it extends.

    text is the text of the scenario's own file, problems has the values that could not be read in
    any of the files, and origins maps the `source` of places to the files.
    """

    text: str
    root: Node
    problems: list[Problem]
    origins: dict[str, Origin]


def chain(origin: Origin) -> Chain:
    """Read the scenario of `origin` and all that it extends, and merge each file over its base.

    Mappings are merged key by key; lists and single values are replaced. Raises
    UnknownScenarioError, UnreadableScenarioError or InvalidScenarioError if a file fails.
    """
    origins: list[Origin] = []
    texts: list[str] = []
    roots: list[Node] = []
    problems: list[Problem] = []
    current: Origin | None = origin
    while current is not None:
        if len(origins) == _MOST_SCENARIOS:
            place = _place(origins[-1].source, 1 - _MOST_SCENARIOS, None)
            text = f"more than {_MOST_SCENARIOS} scenarios, each of which extends the next"
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
    """Return the tree of the last of `origins` without its `extends`, and the base it names."""
    assert isinstance(root.value, dict)
    named = root.value.get(KEY)
    if named is None:
        return root, None
    name = named.value
    if name is Unreadable.UNREADABLE:  # `problems` has the reason
        raise InvalidScenarioError(problems)
    if not isinstance(name, str) or not name:
        text = f"{shown(named.plain())} is not the name of a scenario: a file or a built-in one"
        raise InvalidScenarioError([*problems, Problem(key=KEY, text=text, place=named.place)])
    base = origins[-1].base(name, named.place)
    if base.identity in (identities := [origin.identity for origin in origins]):
        cycle = origins[identities.index(base.identity) :]
        path = " → ".join(one_line(origin.source) for origin in (*cycle, base))
        text = f"{shown(name)} closes a cycle: {path}; allowed: a scenario outside of it"
        raise InvalidScenarioError([*problems, Problem(key=KEY, text=text, place=named.place)])
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
    """Return the mapping in `text`, and the problems with single values.

    A scenario can name any file that this command can read but the author of the scenario cannot.
    So no message shows text of an extended file unless the file looks like a scenario.
    """
    root, problems = parse(text, place_at, top_level=True)
    extended = place_at(None).rank < 0
    if root is None:
        what = "empty; allowed: a mapping ({} for the defaults alone)"
    elif not isinstance(root.value, dict):
        what = f"{kind_of(root.plain())} is not a mapping; the top level must be one"
    elif extended and root.value and not root.value.keys() & schema_at(())["properties"].keys():
        what = "not a scenario: it has no key of one"
    else:
        return root, problems
    known = [] if extended else problems
    raise InvalidScenarioError([*known, Problem(key="", text=what, place=place_at(None))])
