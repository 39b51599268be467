"""Reads the axes of a study: the kind of each, and whether they are compatible."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.series import SERIES
from zenvoy.scenarios import Problem
from zenvoy.scenarios.reading.tree import Node
from zenvoy.studies.sweeps.axes import DISTRIBUTIONS, Axis, Listed, Range, Variants
from zenvoy.studies.sweeps.checking import checked, entries, repeated
from zenvoy.values.wording import dotted, shown

_OWN_KEYS: Final = {"seed": "seeds", "extends": "scenario"}
_COLUMNS: Final = frozenset({"cell", "failure", "time_s", *MEASURES, *SERIES})  # of the tables


def axes_of(node: Node | None) -> tuple[dict[str, Axis], list[Problem]]:
    """Return the axes that a mapping of keys of the scenario describes, and the problems."""
    found: dict[str, Axis] = {}
    problems: list[Problem] = []
    for key, written in entries(node).items():
        axis, of_axis = _axis(key, written)
        problems += of_axis
        if axis is not None:
            problems += _varied_twice(key, axis, found, written)
            found[key] = axis
    samples = {key: axis.size for key, axis in found.items() if axis.random}
    if len(set(samples.values())) > 1:
        each = ", ".join(f"{key}: {size}" for key, size in samples.items())
        text = f"random axes are drawn together, but their samples differ ({each})"
        assert node is not None
        problems.append(Problem(key="axes", text=text, place=node.place))
    return found, problems


def varied(axes: Mapping[str, Axis]) -> list[str]:
    """Return the settings of the scenario that the axes vary."""
    return [name for key, axis in axes.items() for name in axis.keys(key)]


def _axis(key: str, written: Node) -> tuple[Axis | None, list[Problem]]:
    """Return the axis that is written at a key, or None and its problems."""
    path = ("axes", key)
    if problem := _of_the_study(key, ".".join(path), written):
        return None, [problem]
    is_list = isinstance(written.value, tuple)  # short for {values: [...]}
    one = Node({"values": written}, written.place) if is_list else written
    kind = _kind(one, path)
    if isinstance(kind, Problem):
        return None, [kind]
    axis, problems = checked(kind, one, path)
    values = getattr(axis, "values", ())
    problems += repeated(".".join((*path, "values")), values, one, ("values",))
    if isinstance(axis, Variants):
        problems += _variants_problems(key, axis, written)
    return axis, problems


def _of_the_study(key: str, name: str, written: Node) -> Problem | None:
    """Return a problem if a setting cannot be an axis, because the study has its own key for it."""
    if key not in _OWN_KEYS:
        return None
    text = f"is no axis; use the key {_OWN_KEYS[key]} of the study"
    return Problem(key=name, text=text, place=written.place)


def _variants_problems(key: str, axis: Variants, written: Node) -> Iterator[Problem]:
    if key in _COLUMNS:
        text = "is the name of another column of the table; allowed: any other name"
        yield Problem(key=f"axes.{key}", text=text, place=written.place)
    for variant, settings in axis.variants.items():
        for name in settings:
            path = ("variants", variant, name)
            place = written.place_of(path)
            problem = _of_the_study(name, dotted(("axes", key, *path)), Node(None, place))
            if problem is not None:
                yield problem


def _varied_twice(
    key: str, axis: Axis, others: Mapping[str, Axis], written: Node
) -> Iterator[Problem]:
    """Yield a problem for each setting that another axis varies too."""
    known = {name: other for other in others for name in others[other].keys(other)}
    for name in axis.keys(key):
        if name in known:
            text = f"{name} is varied by the axis {known[name]} too"
            yield Problem(key=f"axes.{key}", text=text, place=written.place)


def _kind(node: Node, path: tuple[str, ...]) -> type[Axis] | Problem:
    """Return the kind of axis that the keys of a mapping indicate."""
    if isinstance(node.value, dict):
        if "distribution" in node.value:
            named = node.value["distribution"]
            if isinstance(named.value, str) and named.value in DISTRIBUTIONS:
                return DISTRIBUTIONS[named.value]
            text = f"{shown(named.plain())} is not one of {', '.join(DISTRIBUTIONS)}"
            return Problem(key=".".join((*path, "distribution")), text=text, place=named.place)
        if "values" in node.value:
            return Listed
        if "variants" in node.value:
            return Variants
        if node.value.keys() & {"from", "to", "steps"}:
            return Range
    text = f"{shown(node.plain())} is not an axis; allowed: values, or from, to and steps, or"
    text = f"{text} distribution and samples, or variants"
    return Problem(key=".".join(path), text=text, place=node.place)
