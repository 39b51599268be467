"""The laws of a comparison: each is loaded into the scenario, and has a name of its own."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from zenvoy.analysis.page.style import CYCLE
from zenvoy.fleet.arrays.covered import uncovered
from zenvoy.laws import Law, law_of
from zenvoy.scenarios import (
    COMMAND_LINE,
    Loaded,
    Place,
    Problem,
    Scenario,
    ScenarioError,
    Spelling,
    load,
)
from zenvoy.scenarios.reading.origin import located
from zenvoy.studies.comparison.law_choice import LawChoice, law_choice
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.studies.sweeps.settings import setting_of


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedLaw:
    """A law of a comparison: its name there, the settings that give it, and its colour."""

    label: str
    settings: Mapping[str, Any]
    colour: str
    not_arrays: tuple[str, ...]
    """Why it does not run on arrays; () if it does."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    """The scenario in which laws are compared, with the settings that all of them share."""

    scenario: str
    settings: tuple[str, ...] = ()
    duration_s: float | None = None
    allow_code: bool = False
    spelling: Spelling = COMMAND_LINE
    """How errors spell the arguments of the comparison."""

    def load(self, settings: Sequence[str] = ()) -> Loaded:
        """Return the scenario with further settings; raises ScenarioError."""
        return load(
            self.scenario,
            (*self.settings, *settings),
            duration_s=self.duration_s,
            allow_code=self.allow_code,
            spelling=self.spelling,
        )


def laws_of(
    base: Base, texts: Sequence[str], labels: Sequence[str] = ()
) -> tuple[ComparedLaw, ...]:
    """Return the laws that texts name, each loaded into the scenario.

    `labels` has a name for each, or is empty. Raises ScenarioError with the problems of all.
    """
    if not texts:
        laws = base.spelling.argument("laws")
        raise bad_study("", f"{laws}: no law is given; allowed: one or more")
    origin, model = located(base.scenario), base.load().scenario.control.model
    folder = None if origin.builtin else Path(origin.source).parent
    choices = [law_choice(text, base.spelling).found_from(folder) for text in texts]
    scenarios = _each_loaded(base, choices, model)
    found = [law_of(scenario.control.model) for scenario in scenarios]
    names = _labels(choices, found, labels, base.spelling)
    parts = zip(names, choices, scenarios, _colours(found), strict=True)
    return tuple(
        ComparedLaw(
            label=label,
            settings=choice.settings(model),
            colour=colour,
            not_arrays=tuple(uncovered(scenario)),
        )
        for label, choice, scenario, colour in parts
    )


def _each_loaded(base: Base, choices: Sequence[LawChoice], model: str) -> list[Scenario]:
    """Return the scenario under each law; raises ScenarioError with the problems of all."""
    found: list[Scenario] = []
    problems: dict[str, Problem] = {}
    for choice in choices:
        try:
            found.append(_loaded(base, choice, model).scenario)
        except ScenarioError as error:
            problems |= {str(one): one for one in error.problems}
    if problems:
        raise BadStudyError(problems.values())
    return found


def _loaded(base: Base, choice: LawChoice, model: str) -> Loaded:
    """Return the scenario under a law; problems with the law have the place of its option."""
    settings = [setting_of(key, value) for key, value in choice.settings(model).items()]
    try:
        return base.load(settings)
    except ScenarioError as error:
        own = set(map(base.spelling.setting, settings))
        raise BadStudyError(_at(choice.place, one, own) for one in error.problems) from None


def _at(place: Place, problem: Problem, own: set[str]) -> Problem:
    mine = problem.place is not None and problem.place.source in own
    return replace(problem, place=place) if mine else problem


def _labels(
    choices: Sequence[LawChoice], laws: Sequence[Law], given: Sequence[str], spelling: Spelling
) -> Sequence[str]:
    """Return the labels that are given, or else the shortest names by which the laws differ."""
    if given:
        if len(given) != len(choices):
            text = f"{len(given)} for {len(choices)} laws; give one per law, or none"
            raise bad_study("", f"{spelling.argument('labels')}: {text}")
        for label in given:
            if not label.strip() or given.count(label) > 1:
                what = spelling.option("labels", f"'{label}'")
                raise bad_study("", f"{what}: each law needs a name of its own")
        return given
    for text, count in Counter(choice.text for choice in choices).items():
        if count > 1:
            raise bad_study("", f"{spelling.option('laws', text)}: is given twice; allowed: once")
    names = [law.name for law in laws]
    for found in (names, [_with_parameters(*one) for one in zip(names, choices, strict=True)]):
        if len(set(found)) == len(found):
            return found
    return [choice.text for choice in choices]


def _with_parameters(name: str, choice: LawChoice) -> str:
    brace = choice.text.find("{")
    return name if brace < 0 else f"{name} {choice.text[brace:]}"


def _colours(laws: Sequence[Law]) -> list[str]:
    """Return a colour for each law: that of its record, unless an earlier one has it."""
    found: list[str] = []
    known = {law.colour for law in laws}
    spare = [colour for colour in CYCLE if colour not in known] or list(CYCLE)
    for law in laws:
        if law.colour is not None and law.colour not in found:
            found.append(law.colour)
        else:
            found.append(spare[0])
            spare = [*spare[1:], spare[0]]
    return found
