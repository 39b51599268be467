"""Scenarios by path or by name: read, overridden, validated."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from zenvoy.scenarios.errors import (
    InvalidScenarioError,
    Place,
    Problem,
    UnknownScenarioError,
    UnreadableScenarioError,
)
from zenvoy.scenarios.explain import nearest
from zenvoy.scenarios.library import packaged
from zenvoy.scenarios.overrides import overridden
from zenvoy.scenarios.schema import Scenario
from zenvoy.scenarios.source import parse
from zenvoy.scenarios.tree import Node
from zenvoy.scenarios.validate import validated
from zenvoy.scenarios.wording import shown


@dataclass(frozen=True, slots=True, kw_only=True)
class Loaded:
    """A scenario, what it is called, and the text it was read from, without the overrides."""

    name: str
    scenario: Scenario
    text: str


def load(
    name_or_path: str | Path,
    overrides: Sequence[str] = (),
    *,
    seed: int | None = None,
    duration_s: float | None = None,
) -> Loaded:
    """The scenario in an existing file, or else the built-in one of that name.

    overrides are `key=value` with a dotted key and a value in YAML (channel.loss.p=0.3); seed and
    duration_s are put in after them. Raises UnknownScenarioError, UnreadableScenarioError or
    InvalidScenarioError, each a ScenarioError.
    """
    name, source, read = _located(name_or_path)
    text = _text(read, source)
    root, problems = _tree(text, source)
    root, more = overridden(root, overrides, {"seed": seed, "duration_s": duration_s})
    return Loaded(name=name, scenario=validated(root, [*problems, *more]), text=text)


def builtin() -> list[tuple[str, str]]:
    """Name and description of every built-in scenario, in order of name."""
    return [(name, load(name).scenario.description) for name in packaged()]


def _located(name_or_path: str | Path) -> tuple[str, str, Callable[[], bytes]]:
    """Name, source as messages call it, and reader."""
    path = Path(name_or_path)
    # os.path, unlike Path, answers False to names that no file can have.
    if os.path.exists(path) and not os.path.isdir(path):
        return path.stem, str(name_or_path), path.read_bytes
    name, known = str(name_or_path), packaged()
    if name in known:
        return name, f"built-in {name}", known[name].read_bytes
    names = list(known)
    text = (
        f"{shown(name)} is neither a file nor a built-in scenario; "
        f"{nearest(name, names)}built-in: {', '.join(names)}"
    )
    raise UnknownScenarioError([Problem(key="", text=text)])


def _text(read: Callable[[], bytes], source: str) -> str:
    try:
        data = read()
    except OSError as error:
        problem = Problem(
            key="", text=f"cannot be read: {error.strerror}", place=Place(source=source)
        )
        raise UnreadableScenarioError([problem]) from error
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        place = Place(source=source, line=data.count(b"\n", 0, error.start) + 1)
        text = f"not UTF-8: byte 0x{data[error.start]:02x}"
        raise UnreadableScenarioError([Problem(key="", text=text, place=place)]) from None


def _tree(text: str, source: str) -> tuple[Node, list[Problem]]:
    root, problems = parse(text, lambda line: Place(source=source, line=line))
    if root is not None and isinstance(root.value, dict):
        return root, problems
    if root is None:
        what = "empty; allowed: a mapping ({} for the defaults alone)"
    else:
        what = f"{shown(root.plain())} is not a mapping, as the top level has to be"
    raise InvalidScenarioError([*problems, Problem(key="", text=what, place=Place(source=source))])
