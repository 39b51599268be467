"""The runs of a study: a cell for each combination of its axes, with a run for each seed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.fleet.choice import EngineError, choose
from zenvoy.fleet.engine import Engine
from zenvoy.scenarios import Problem, Scenario, ScenarioError
from zenvoy.scenarios.errors import MOST_PROBLEMS
from zenvoy.studies.cell import Cell, key_of
from zenvoy.studies.sweeps.axes import Axis
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.studies.sweeps.settings import setting_of
from zenvoy.studies.sweeps.study_file import StudyFile
from zenvoy.values.wording import listed

MOST_RUNS: Final = 100_000

_MOST_BAD_CELLS: Final = 200  # after so many, a plan stops looking for further problems

Point = dict[str, Any]
"""A value for each axis, in their order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCell:
    """A combination of the axes, numbered from 1, and the key of its run with each seed."""

    number: int
    point: Point
    settings: tuple[str, ...]
    keys: tuple[str, ...]
    engine: Engine

    def __str__(self) -> str:
        return " ".join(setting_of(key, value) for key, value in self.point.items())


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """All runs of a study. The last axis varies fastest."""

    study: StudyFile
    seeds: tuple[int, ...]
    cells: tuple[PlannedCell, ...]
    allow_code: bool = False
    """Whether laws may lie anywhere, not only beside the scenario."""

    @property
    def runs(self) -> int:
        """The number of runs, one for each cell and seed."""
        return len(self.cells) * len(self.seeds)

    def cell(self, planned: PlannedCell, seed: int) -> Cell:
        """Return one run of a cell."""
        return _cell(self.study, planned.settings, seed, self.allow_code)


def size_of(axes: Mapping[str, Axis]) -> int:
    """Return the number of points without making them."""
    random = {axis.size for axis in axes.values() if axis.random}
    return math.prod(axis.size for axis in axes.values() if not axis.random) * math.prod(random)


def points_of(axes: Mapping[str, Axis]) -> Iterator[Point]:
    """Yield every combination of the axes; the last one varies fastest.

    All random axes together are one factor: its draw i has draw i of each of them. It takes the
    place of the first random axis.
    """
    factors: list[list[Point]] = []
    random = {key: axis for key, axis in axes.items() if axis.random}
    for key, axis in axes.items():
        if not axis.random:
            factors.append([{key: value} for value in axis.values_of(key)])
        elif key == next(iter(random)):
            columns = [one.values_of(name) for name, one in random.items()]
            factors.append(
                [dict(zip(random, row, strict=True)) for row in zip(*columns, strict=True)]
            )
    for parts in product(*factors):
        whole = {key: value for part in parts for key, value in part.items()}
        yield {key: whole[key] for key in axes}


def plan_of(study: StudyFile, *, allow_code: bool = False) -> Plan:
    """Return the runs of a study; every cell's scenario is loaded and checked.

    Loading runs the code of its laws, which must lie beside the scenario unless `allow_code`.
    Raises BadStudyError with the problems of the study in the scenario's own words, or with the
    number of runs if there are more than MOST_RUNS.
    """
    cells = size_of(study.axes)
    if cells * study.seed_count > MOST_RUNS:
        text = f"{counted(cells, 'cell')} × {counted(study.seed_count, 'seed')} are"
        text += f" {cells * study.seed_count:,} runs; allowed: at most {MOST_RUNS:,}"
        raise bad_study("axes", text, study.places["axes"])
    seeds = study.each_seed
    planned: list[PlannedCell] = []
    problems: dict[str, Problem] = {}
    bad = 0
    for number, point in enumerate(points_of(study.axes), start=1):
        causes = {key: study.axes[key].settings_of(key, value) for key, value in point.items()}
        settings = (*study.settings, *(one for of_axis in causes.values() for one in of_axis))
        try:
            cell = _cell(study, settings, seeds[0], allow_code)
            scenario = cell.load(study.spelling).scenario
            _require_lock_step(scenario.clock, study)
            engine = _engine(scenario, study)
        except ScenarioError as error:
            bad += 1
            for problem in (_placed(one, study, causes) for one in error.problems):
                problems.setdefault(f"{problem.key}: {problem.text}", problem)
            if bad >= _MOST_BAD_CELLS or len(problems) >= MOST_PROBLEMS:
                break
            continue
        keys = tuple(key_of(scenario.model_copy(update={"seed": seed})) for seed in seeds)
        planned.append(
            PlannedCell(number=number, point=point, settings=settings, keys=keys, engine=engine)
        )
    if problems:
        raise BadStudyError(problems.values())
    return Plan(study=study, seeds=seeds, cells=tuple(planned), allow_code=allow_code)


def _cell(study: StudyFile, settings: tuple[str, ...], seed: int, allow_code: bool) -> Cell:
    return Cell(
        scenario=study.scenario,
        seed=seed,
        settings=settings,
        duration_s=study.duration_s,
        allow_code=allow_code,
    )


def _require_lock_step(clock: str, study: StudyFile) -> None:
    if clock == "realtime":
        text = "realtime; a study runs as fast as it can; allowed: lock-step"
        raise bad_study("clock", text, study.places["scenario"])


def _engine(scenario: Scenario, study: StudyFile) -> Engine:
    """Return the engine of a cell's runs; arrays make no log, which some measures need."""
    if study.engine != "in-process" and study.needs_log:
        if study.engine == "auto":
            return "in-process"
        named = [name for name in study.measures or () if MEASURES[name].needs_log]
        text = f"{listed(named)}: counted in a log; allowed with engine: auto or in-process"
        raise bad_study("measures", text, study.places["measures"])
    try:
        return choose(study.engine, scenario).engine
    except EngineError as error:
        place = study.places["engine"]
        lines = str(error).splitlines()
        raise BadStudyError(
            Problem(key="engine", text=line, place=place) for line in lines
        ) from None


def _placed(problem: Problem, study: StudyFile, of_axes: Mapping[str, Sequence[str]]) -> Problem:
    """Return a problem at the axis or the setting of the study that causes it, if one does.

    `of_axes` has the settings of the cell by axis.
    """
    if problem.place is None:
        return replace(problem, key="scenario", place=study.places["scenario"])
    if problem.place in study.places.values():
        return problem
    source, places, spelled = problem.place.source, study.places, study.spelling
    causes = [key for key, settings in of_axes.items() if source in map(spelled.setting, settings)]
    for key, axis in study.axes.items():
        others = (problem.key, *problem.related)
        if any(_related(name, other) for name in axis.keys(key) for other in others):
            causes.append(key)
    if not causes and source in map(spelled.setting, study.settings):
        causes = ["settings"]
    if not causes and source == spelled.option("duration_s", study.duration_s):
        causes = ["duration_s"]
    return replace(problem, place=places[causes[0]]) if causes else problem


def _related(key: str, other: str) -> bool:
    return key == other or key.startswith(f"{other}.") or other.startswith(f"{key}.")


def counted(number: int, what: str) -> str:
    """Return "1 seed" or "1,000 seeds"."""
    return f"{number:,} {what}{'' if number == 1 else 's'}"
