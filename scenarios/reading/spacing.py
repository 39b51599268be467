"""Converts spacing from bumper to bumper into spacing from front to front."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from zenvoy.scenarios.errors import Problem
from zenvoy.scenarios.reading.tree import Node, planted
from zenvoy.values.section import LARGEST
from zenvoy.values.wording import dotted, shown, trimmed

GAP: Final = ("bumper_gap_m", "gap_m")
DESIRED_GAP: Final = ("desired_bumper_gap_m", "desired_gap_m")

_SECTIONS: Final = (
    (("fleet",), GAP),
    (("control",), DESIRED_GAP),
    (("fleet", "groups"), DESIRED_GAP),
    (("control", "schedule"), DESIRED_GAP),
)
_LENGTH_M: Final = 5.0  # the default of fleet.length_m


def with_spacing(root: Node) -> tuple[Node, list[Problem]]:
    """Return `root` with every spacing from front to front, and the problems with the others.

    If both forms are given, the later one counts: a scenario over the one that it extends, the
    command line over the file. Both forms in one place are refused.
    """
    problems: list[Problem] = []
    length_m = _number(root.find(("fleet", "length_m"))) or _LENGTH_M
    for path, names in _SECTIONS:
        node = root.find(path)
        if node is None:
            continue
        if isinstance(node.value, tuple):
            filled = [
                _filled(item, dotted((*path, index)), names, length_m)
                for index, item in enumerate(node.value)
            ]
            node = replace(node, value=tuple(item for item, _ in filled))
            problems += [problem for _, problem in filled if problem is not None]
        else:
            node, problem = _filled(node, dotted(path), names, length_m)
            problems += [problem] if problem is not None else []
        root = planted(root, path, node)
    return root, problems


def _filled(
    section: Node, key: str, names: tuple[str, str], length_m: float
) -> tuple[Node, Problem | None]:
    """Return a section with the spacing from front to front, and the problem with the other."""
    if not isinstance(section.value, dict) or names[0] not in section.value:
        return section, None
    bumper, front = section.value[names[0]], section.value.get(names[1])
    rest = {name: child for name, child in section.value.items() if name != names[0]}
    value, wrong = _number(bumper), ""
    if front is not None and front.place.rank > bumper.place.rank:
        return replace(section, value=rest), None
    if front is not None and front.place.rank == bumper.place.rank:
        wrong = f"given together with {names[1]}; allowed: one of the two"
    elif value is None:
        wrong = f"{shown(bumper.plain())} is not a number"
    elif not 0.0 < value <= LARGEST:
        wrong = f"{trimmed(value)} is not in (0, 1e9]"
    else:
        rest[names[1]] = Node(value + length_m, bumper.place)
    section = replace(section, value=rest)
    return section, Problem(
        key=f"{key}.{names[0]}", text=wrong, place=bumper.place
    ) if wrong else None


def _number(node: Node | None) -> float | None:
    value = None if node is None else node.value
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
