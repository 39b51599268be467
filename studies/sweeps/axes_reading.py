"""Reads the axes of a study: the kind of each, and whether they go together."""

from __future__ import annotations

from typing import Final

from zenvoy.scenarios import Problem
from zenvoy.scenarios.reading.tree import Node
from zenvoy.studies.sweeps.axes import DISTRIBUTIONS, Axis, Listed, Range
from zenvoy.studies.sweeps.checking import checked, entries, repeated
from zenvoy.values.wording import shown

_OWN_KEYS: Final = {"seed": "seeds", "extends": "scenario"}


def axes_of(node: Node | None) -> tuple[dict[str, Axis], list[Problem]]:
    """Return the axes that a mapping of keys of the scenario describes, and the problems."""
    found: dict[str, Axis] = {}
    problems: list[Problem] = []
    for key, written in entries(node).items():
        path = ("axes", key)
        if key in _OWN_KEYS:
            text = f"is no axis; use the key {_OWN_KEYS[key]} of the study"
            problems.append(Problem(key=".".join(path), text=text, place=written.place))
            continue
        is_list = isinstance(written.value, tuple)  # short for {values: [...]}
        one = Node({"values": written}, written.place) if is_list else written
        kind = _kind(one, path)
        if isinstance(kind, Problem):
            problems.append(kind)
            continue
        axis, of_axis = checked(kind, one, path)
        problems += of_axis
        if axis is not None:
            found[key] = axis
            values = getattr(axis, "values", ())
            problems += repeated(".".join((*path, "values")), values, one, ("values",))
    samples = {key: axis.size for key, axis in found.items() if axis.random}
    if len(set(samples.values())) > 1:
        each = ", ".join(f"{key}: {size}" for key, size in samples.items())
        text = f"random axes are drawn together, but their samples differ ({each})"
        assert node is not None
        problems.append(Problem(key="axes", text=text, place=node.place))
    return found, problems


def _kind(node: Node, path: tuple[str, ...]) -> type[Axis] | Problem:
    """Return the kind of axis that a mapping's keys say."""
    if isinstance(node.value, dict):
        if "distribution" in node.value:
            named = node.value["distribution"]
            if isinstance(named.value, str) and named.value in DISTRIBUTIONS:
                return DISTRIBUTIONS[named.value]
            text = f"{shown(named.plain())} is not one of {', '.join(DISTRIBUTIONS)}"
            return Problem(key=".".join((*path, "distribution")), text=text, place=named.place)
        if "values" in node.value:
            return Listed
        if node.value.keys() & {"from", "to", "steps"}:
            return Range
    text = f"{shown(node.plain())} is not an axis; allowed: values, or from, to and steps, or"
    return Problem(key=".".join(path), text=f"{text} distribution and samples", place=node.place)
