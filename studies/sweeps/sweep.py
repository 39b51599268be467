"""Runs a study: makes its missing runs, then its tables and pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from zenvoy.scenarios import COMMAND_LINE, Spelling
from zenvoy.studies.extras import missing
from zenvoy.studies.sweeps.crew import Cores, Crew
from zenvoy.studies.sweeps.errors import NoClusterError, bad_study
from zenvoy.studies.sweeps.page import README, write_results
from zenvoy.studies.sweeps.plan import Plan, counted, plan_of
from zenvoy.studies.sweeps.results import Results, results_of
from zenvoy.studies.sweeps.store import Store, open_store
from zenvoy.studies.sweeps.study_file import StudyFile, read_study
from zenvoy.studies.sweeps.tasks import Task, missing_tasks
from zenvoy.studies.sweeps.workers import Done

Study = str | PathLike[str] | Mapping[str, Any]

OnLine = Callable[[str], None]
"""Called with a line of text for each run that is done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Swept:
    """The outcome of a sweep: its results, its folder, and the files that it wrote."""

    results: Results
    folder: Path
    files: tuple[Path, ...]

    @property
    def readme(self) -> Path:
        """The page that says what was run, and what failed."""
        return self.folder / README


def run_sweep(
    study: Study,
    *,
    out: Path | None,
    jobs: int | None,
    on_line: OnLine,
    command: str,
    allow_code: bool = False,
    dask: str | None = None,
    spelling: Spelling = COMMAND_LINE,
) -> Swept:
    """Make the missing runs of a study, then write its results.

    `out` is runs/<name of the study> by default. `jobs` is the number of processes at a time, by
    default one for each core. With `dask`, the address of a scheduler, the workers of its cluster
    make the runs. A run that fails is reported on a line, and the others go on. Laws must lie
    beside the scenario unless `allow_code`. Errors have the given `spelling`.

    Raises BadStudyError or NoClusterError before anything is run, and ClusterError or OSError.
    Finished runs are kept in the folder, also after an interruption.
    """
    made = make_runs(
        read_study(study, spelling),
        out=out,
        jobs=jobs,
        on_line=on_line,
        allow_code=allow_code,
        dask=dask,
    )
    files = write_results(made.results, made.store, command)
    return Swept(results=made.results, folder=made.store.folder, files=tuple(files))


class Made(NamedTuple):
    """The results of a study, and the folder that keeps its runs."""

    results: Results
    store: Store


def make_runs(
    study: StudyFile,
    *,
    out: Path | None,
    jobs: int | None,
    on_line: OnLine,
    allow_code: bool = False,
    dask: str | None = None,
) -> Made:
    """Make the missing runs of a study that is read; see `run_sweep`."""
    plan = plan_of(study, allow_code=allow_code)
    folder = Path("runs") / study.name if out is None else out
    with _crew(jobs, dask, on_line, study.spelling) as crew:
        store = open_store(folder, study)
        failures = _made_by(crew, plan, store, on_line)
    return Made(results_of(plan, store, failures), store)


def _crew(
    jobs: int | None, dask: str | None, on_line: OnLine, spelling: Spelling
) -> AbstractContextManager[Crew]:
    """Return the crew that makes the runs; entering it raises NoClusterError."""
    if dask is None:
        return nullcontext(Cores(jobs or len(os.sched_getaffinity(0))))
    if jobs is not None:
        text = f"{spelling.argument('jobs')}: with {spelling.argument('dask')}, the workers say"
        raise bad_study("", f"{text} how many runs go at a time")
    if line := missing("distributed"):
        raise NoClusterError(line)
    from zenvoy.studies.sweeps.cluster.crew import cluster_at  # Dask takes a second to import

    return cluster_at(dask, on_line, spelling)


def make_missing(plan: Plan, store: Store, jobs: int, on_line: OnLine) -> dict[str, str]:
    """Make the runs that the store lacks on local cores, and return by key why runs failed."""
    return _made_by(Cores(jobs), plan, store, on_line)


def _made_by(crew: Crew, plan: Plan, store: Store, on_line: OnLine) -> dict[str, str]:
    """Let the crew make the runs that the store lacks, and return by key why runs failed."""
    tasks = missing_tasks(plan, store, crew.at_a_time)
    missing = sum(len(task.keys) for task in tasks)
    size = f"{counted(len(plan.cells), 'cell')} × {counted(len(plan.seeds), 'seed')}"
    on_line(f"{size}: {counted(plan.runs, 'run')}, {missing} to do")
    failures: dict[str, str] = {}
    count = 0
    while tasks:
        alone: list[Task] = []
        for done in crew.each_done(tasks, plan, store):
            if done.failure is not None and len(done.task.keys) > 1:
                # Find out which run of the batch fails.
                left = [one for one in done.task.split() if not store.has(one.key, plan.study)]
                count += len(done.task.keys) - len(left)
                alone += left
                continue
            count += len(done.task.keys)
            failures |= _failures(done, plan, store)
            failed = "" if done.failure is None else f" failed: {done.failure}"
            on_line(f"{count} of {missing}: {done.task}{failed}")
        tasks = alone
    return failures


def _failures(done: Done[Task], plan: Plan, store: Store) -> dict[str, str]:
    if done.failure is None:
        return {}
    return {key: done.failure for key in done.task.keys if not store.has(key, plan.study)}
