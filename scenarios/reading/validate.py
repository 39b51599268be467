"""Turns a tree of values into a Scenario, or into all the problems with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from zenvoy.scenarios.errors import (
    MOST_PROBLEMS,
    InvalidScenarioError,
    Problem,
    ScenarioError,
    order_of,
)
from zenvoy.scenarios.reading.allowed import stand_in
from zenvoy.scenarios.reading.explain import Refusal, explained, is_reported, refusal
from zenvoy.scenarios.reading.tree import Node
from zenvoy.scenarios.schema.agreement import DisagreementError
from zenvoy.scenarios.schema.scenario import Scenario


def validated(
    root: Node, known: Sequence[Problem] = (), errors: Sequence[ScenarioError] = ()
) -> Scenario:
    """Return the scenario that `root`, a mapping, describes.

    Raises InvalidScenarioError with every problem, including those that are known already.
    """
    problems = [*known, *(problem for error in errors for problem in error.problems)]
    more = sum(error.more for error in errors)
    try:
        scenario = Scenario.model_validate(root.plain())
    except ValidationError as refused:
        found, others = _problems(refused.errors(include_url=False), root)
        problems += found
        more += others
    if problems:
        raise InvalidScenarioError(problems, more)
    return scenario


def placed(notes: Iterable[Problem], root: Node) -> Iterator[Problem]:
    """Return each note with the place of the value that causes it."""
    return (_placed(note, root) for note in notes)


def _problems(errors: list[ErrorDetails], root: Node) -> tuple[list[Problem], int]:
    """Return the problems, up to the limit in order of their places, and the number of others.

    A file written by a program may repeat an error thousands of times, and each explanation takes
    time.
    """
    if found := _disagreements(errors):
        return [_placed(problem, root) for problem in found], 0
    refusals = [refusal(error) for error in errors]
    unreported = [refused for refused in refusals if not is_reported(refused)]
    if len(unreported) > MOST_PROBLEMS:
        unreported.sort(key=lambda refused: order_of(root.place_of(refused.path)))
        first = [explained(refused, root) for refused in unreported[:MOST_PROBLEMS]]
        return first, len(unreported) - MOST_PROBLEMS
    problems = [explained(refused, root) for refused in unreported]
    bad = {tuple(map(str, refused.path)) for refused in refusals}
    for problem in _disagreements(_errors(_repaired(root, refusals))):
        if not any(_within(key, bad) for key in (problem.key, *problem.related)):
            problems.append(_placed(problem, root))
    return problems, 0


def _disagreements(errors: Iterable[ErrorDetails]) -> list[Problem]:
    causes = [error.get("ctx", {}).get("error") for error in errors]
    return [p for cause in causes if isinstance(cause, DisagreementError) for p in cause.problems]


def _errors(plain: object) -> list[ErrorDetails]:
    try:
        Scenario.model_validate(plain)
    except ValidationError as refused:
        return refused.errors(include_url=False)
    return []


def _repaired(root: Node, refusals: list[Refusal]) -> object:
    """Return the values with stand-ins for the refused ones, so that pydantic compares sections."""
    plain = root.plain()
    for path, kind, _, schema in refusals:
        *parents, last = path
        holder: Any = plain
        for step in parents:
            holder = holder[step]
        if kind == "extra_forbidden":
            del holder[last]
        elif isinstance(holder, list) and last == len(holder):  # the entry is missing
            holder.append(stand_in(schema))
        else:
            holder[last] = stand_in(schema)
    return plain


def _within(key: str, bad: set[tuple[str, ...]]) -> bool:
    path = tuple(key.split("."))
    return any(path[:length] in bad for length in range(1, len(path) + 1))


def _placed(problem: Problem, root: Node) -> Problem:
    """Return `problem` at the option that causes it, else at the first of its keys in the file."""
    nodes = [root.find(key.split(".")) for key in (problem.key, *problem.related)]
    written = [node.place for node in nodes if node]
    place = max(written, key=lambda place: place.rank, default=root.place)
    return Problem(key=problem.key, text=problem.text, place=place, related=problem.related)
