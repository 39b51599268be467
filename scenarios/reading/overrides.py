"""Applies `key=value` settings and options of a front end to the tree of a scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from zenvoy.scenarios.errors import Place, Problem, ScenarioError
from zenvoy.scenarios.reading.source import DEEPEST, parse
from zenvoy.scenarios.reading.spelling import Spelling
from zenvoy.scenarios.reading.tree import Node, planted
from zenvoy.values.wording import dotted


def overridden(
    root: Node,
    settings: Sequence[str],
    options: Mapping[str, int | float | str | None],
    spelling: Spelling,
) -> tuple[Node, list[Problem]]:
    """Return `root` with each `key=value` of `settings` applied, then each option but None.

    options maps keys of the top level (seed, speed) to values. A setting that cannot be applied is
    left out, and reported as a problem.
    """
    problems: list[Problem] = []
    for rank, setting in enumerate(settings, start=1):
        try:
            place = Place(source=spelling.setting(setting), rank=rank)
            root, found = _with_setting(root, setting, place)
            problems += found
        except ScenarioError as error:
            problems += error.problems
    for rank, (key, value) in enumerate(options.items(), start=len(settings) + 1):
        if value is not None:
            place = Place(source=spelling.option(key, value), rank=rank)
            root = planted(root, (key,), Node(value, place))
    return root, problems


def _with_setting(root: Node, setting: str, place: Place) -> tuple[Node, list[Problem]]:
    key, equals, text = setting.partition("=")
    path = tuple(step.strip() for step in key.split("."))
    if not equals or not all(path) or len(path) > DEEPEST:
        what = "not of the form key=value, such as channel.loss.p=0.3"
        return root, [Problem(key="", text=what, place=place)]
    if path[0] == "extends":
        what = "cannot be set; allowed in a file only"
        return root, [Problem(key=dotted(path), text=what, place=place)]
    value, problems = parse(text, lambda _: place, path)
    return planted(root, path, value or Node(None, place)), problems
