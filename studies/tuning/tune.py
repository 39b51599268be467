"""Runs a search: makes its missing trials one after the other, then its results."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from zenvoy.scenarios import COMMAND_LINE, Problem, ScenarioError, Spelling
from zenvoy.scenarios.errors import MOST_PROBLEMS
from zenvoy.studies.cell import key_of
from zenvoy.studies.sweeps.errors import BadStudyError, bad_study
from zenvoy.studies.sweeps.page import README
from zenvoy.studies.sweeps.plan import Plan, Point, counted
from zenvoy.studies.sweeps.store import Store, open_folder
from zenvoy.studies.sweeps.sweep import OnLine, Study
from zenvoy.studies.tuning.figures import in_theory, is_theoretical
from zenvoy.studies.tuning.folder import held
from zenvoy.studies.tuning.page import write_results
from zenvoy.studies.tuning.reading import read_tune_study
from zenvoy.studies.tuning.search import proposal
from zenvoy.studies.tuning.storage import Trials
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.trial import Trial, best_of
from zenvoy.studies.tuning.trying import tried


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuned:
    """The outcome of a search: its trials, its folder, and the files that it wrote."""

    study: TuneStudy
    trials: tuple[Trial, ...]
    folder: Path
    files: tuple[Path, ...]

    @property
    def best(self) -> Trial | None:
        """The best feasible trial; None if no trial is feasible."""
        return best_of(self.study, self.trials)

    @property
    def failed(self) -> int:
        """The number of trials that failed."""
        return sum(trial.failure is not None for trial in self.trials)

    @property
    def readme(self) -> Path:
        """The page that says what was found."""
        return self.folder / README


def run_tune(
    study: Study,
    *,
    out: Path | None,
    jobs: int | None,
    on_line: OnLine,
    command: str,
    allow_code: bool = False,
    spelling: Spelling = COMMAND_LINE,
) -> Tuned:
    """Make the missing trials of a study, then write its results.

    `out` is runs/<name of the study> by default. `jobs` is the number of processes for the seeds of
    a trial, by default one for each core. A trial that fails is reported on a line, and the others
    go on. Laws must lie beside the scenario unless `allow_code`. Errors have the given `spelling`.

    Raises BadStudyError before anything is run, and OSError. Finished trials are kept in the
    folder, also after an interruption.
    """
    checked = read_tune_study(study, allow_code=allow_code, spelling=spelling)
    identity = {**_scenario(checked), **checked.identity}
    folder = Path("runs") / checked.name if out is None else out
    with held(folder, spelling):
        open_folder(folder, json.loads(json.dumps(identity)), checked.runs.text, spelling)
        trials = _make_missing(checked, folder, jobs or len(os.sched_getaffinity(0)), on_line)
        files = write_results(checked, trials, folder, command)
    return Tuned(study=checked, trials=trials, folder=folder, files=tuple(files))


def _make_missing(study: TuneStudy, folder: Path, jobs: int, on_line: OnLine) -> tuple[Trial, ...]:
    kept, store = Trials(folder, study), Store(folder=folder)
    missing = max(0, study.trials - len(kept.finished))
    seeds = counted(len(study.seeds), "seed")
    on_line(f"{counted(study.trials, 'trial')} × {seeds}, {missing} to do")
    for number in range(len(kept.finished) + 1, study.trials + 1):
        point = proposal(study, kept.finished)
        trial = tried(study, number, point, store, jobs)
        kept.add(trial)
        on_line(f"{number} of {study.trials}: {trial.settings}: {trial.told(study)}")
    return tuple(kept.finished[: study.trials])


def _scenario(study: TuneStudy) -> dict[str, Any]:
    """Check the scenario at the ends of all ranges, and return what identifies it.

    Raises BadStudyError with the problems of the study in the scenario's own words.
    """
    plans: list[Plan] = []
    problems: dict[str, Problem] = {}
    for point in _points(study):
        try:
            plans.append(study.plan_at(point))
        except ScenarioError as error:
            for problem in error.problems:
                problems.setdefault(f"{problem.key}: {problem.text}", problem)
        if len(problems) >= MOST_PROBLEMS:
            break
    if problems:
        raise BadStudyError(problems.values())
    scenarios = [plan.cell(plan.cells[0], plan.seeds[0]).load().scenario for plan in plans]
    for name in filter(is_theoretical, study.figures):
        reasons = [in_theory(name, scenario) for scenario in scenarios]
        if all(isinstance(reason, str) for reason in reasons):
            key = study.direction if name == study.figure else "constraints"
            raise bad_study(key, str(reasons[0]), study.runs.places[key])
    named = Path(study.runs.scenario)
    return {
        "scenario": named.name if named.is_file() else study.runs.scenario,
        "content of the scenario": key_of(scenarios[0]),
    }


def _points(study: TuneStudy) -> list[Point]:
    """Return the point with the first value of each parameter, and those that vary one of them."""
    first = {key: one.samples[0] for key, one in study.parameters.items()}
    others = [
        {**first, key: value} for key, one in study.parameters.items() for value in one.samples[1:]
    ]
    return [first, *others]
