"""Converts spacing from bumper to bumper into spacing from front to front."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

from zenvoy.scenarios.errors import Place, Problem
from zenvoy.scenarios.reading.tree import Node, planted
from zenvoy.values.section import LARGEST
from zenvoy.values.wording import dotted, shown, trimmed

GAP: Final = ("bumper_gap_m", "gap_m")
DESIRED_GAP: Final = ("desired_bumper_gap_m", "desired_gap_m")
REPORTED: Final = ("fleet", "reported_gaps")

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
    command line over the file. Both forms in one place are refused. Where a spacing from bumper to
    bumper counts, reports have gaps of this kind, unless `fleet.reported_gaps` is given.
    """
    problems: list[Problem] = []
    length_m = _number(root.find(("fleet", "length_m"))) or _LENGTH_M
    place: Place | None = None
    for path, names in _SECTIONS:
        node = root.find(path)
        if node is None:
            continue
        if isinstance(node.value, tuple):
            named = [(item, dotted((*path, index))) for index, item in enumerate(node.value)]
            filled = [_filled(item, key, names, length_m) for item, key in named]
            node = replace(node, value=tuple(one.section for one in filled))
        else:
            filled = [_filled(node, dotted(path), names, length_m)]
            node = filled[0].section
        problems += [one.problem for one in filled if one.problem is not None]
        place = next((one.bumper for one in filled if one.bumper is not None), place)
        root = planted(root, path, node)
    if place is not None and root.find(REPORTED) is None:
        root = planted(root, REPORTED, Node("bumper-to-bumper", place))
    return root, problems


class _Filled(NamedTuple):
    """A section with the spacing from front to front, and the problem with the other.

    `bumper` is where a spacing from bumper to bumper is written, if it is the one that counts.
    """

    section: Node
    problem: Problem | None = None
    bumper: Place | None = None


def _filled(section: Node, key: str, names: tuple[str, str], length_m: float) -> _Filled:
    if not isinstance(section.value, dict) or names[0] not in section.value:
        return _Filled(section)
    bumper, front = section.value[names[0]], section.value.get(names[1])
    rest = {name: child for name, child in section.value.items() if name != names[0]}
    value, wrong = _number(bumper), ""
    if front is not None and front.place.rank > bumper.place.rank:
        return _Filled(replace(section, value=rest))
    if front is not None and front.place.rank == bumper.place.rank:
        wrong = f"given together with {names[1]}; allowed: one of the two"
    elif value is None:
        wrong = f"{shown(bumper.plain())} is not a number"
    elif not 0.0 < value <= LARGEST:
        wrong = f"{trimmed(value)} is not in (0, 1e9]"
    else:
        rest[names[1]] = Node(value + length_m, bumper.place)
    section = replace(section, value=rest)
    if not wrong:
        return _Filled(section, bumper=bumper.place)
    return _Filled(section, Problem(key=f"{key}.{names[0]}", text=wrong, place=bumper.place))


def _number(node: Node | None) -> float | None:
    value = None if node is None else node.value
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
