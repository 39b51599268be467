"""Runs a study: makes its missing runs, then its tables and pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, Final

from zenvoy.studies.sweeps.page import README, write_results
from zenvoy.studies.sweeps.plan import Plan, PlannedCell, counted, plan_of
from zenvoy.studies.sweeps.results import Results, results_of
from zenvoy.studies.sweeps.running import keep_runs
from zenvoy.studies.sweeps.store import Store, open_store
from zenvoy.studies.sweeps.study_file import read_study
from zenvoy.studies.sweeps.workers import Done, each_done

_MOST_SEEDS: Final = 100  # of a batch: more are hardly faster, and a stop would lose more

Study = str | PathLike[str] | Mapping[str, Any]

OnLine = Callable[[str], None]
"""Called with a line of text for each run that is done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Runs of a cell that one process makes."""

    cell: PlannedCell
    seeds: tuple[int, ...]
    keys: tuple[str, ...]

    @property
    def key(self) -> str:
        """Key of its only or first run."""
        return self.keys[0]

    def split(self) -> list[Task]:
        """Return a task for each of its runs."""
        pairs = zip(self.seeds, self.keys, strict=True)
        return [Task(cell=self.cell, seeds=(seed,), keys=(key,)) for seed, key in pairs]

    def __str__(self) -> str:
        seeds = " ".join(map(str, self.seeds[:3])) + (" …" if len(self.seeds) > 3 else "")
        return f"{self.cell}, seed{'s' if len(self.seeds) > 1 else ''} {seeds}"


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
) -> Swept:
    """Make the missing runs of a study, then write its results.

    `out` is runs/<name of the study> by default. `jobs` is the number of processes at a time, by
    default one for each core. A run that fails is reported on a line, and the others go on. Laws
    must lie beside the scenario unless `allow_code`. Raises BadStudyError before anything is run,
    and OSError. Finished runs are kept in the folder, also after an interruption.
    """
    checked = read_study(study)
    plan = plan_of(checked, allow_code=allow_code)
    folder = Path("runs") / checked.name if out is None else out
    store = open_store(folder, checked)
    failures = make_missing(plan, store, jobs or len(os.sched_getaffinity(0)), on_line)
    results = results_of(plan, store, failures)
    files = write_results(results, store, command)
    return Swept(results=results, folder=folder, files=tuple(files))


def make_missing(plan: Plan, store: Store, jobs: int, on_line: OnLine) -> dict[str, str]:
    """Make the runs that the store lacks, and return by key why runs failed."""
    tasks = _tasks(plan, store, jobs)
    missing = sum(len(task.keys) for task in tasks)
    size = f"{counted(len(plan.cells), 'cell')} × {counted(len(plan.seeds), 'seed')}"
    on_line(f"{size}: {counted(plan.runs, 'run')}, {missing} to do")
    failures: dict[str, str] = {}
    count = 0
    do = partial(_make, plan, store)
    while tasks:
        alone: list[Task] = []
        for done in each_done(tasks, do, jobs):
            if (
                done.failure is not None and len(done.task.keys) > 1
            ):  # find out which run of the batch fails
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


def _tasks(plan: Plan, store: Store, jobs: int) -> list[Task]:
    """Return tasks for the missing runs; equal combinations are run once.

    On arrays a task has many seeds of a cell. On other engines it has one run, and the tasks go
    seed by seed, so that a stopped sweep has all cells of some seeds.
    """
    taken: set[str] = set()
    missing: list[Task] = []
    for cell in plan.cells:
        pairs = zip(plan.seeds, cell.keys, strict=True)
        left = [(s, k) for s, k in pairs if k not in taken and not store.has(k, plan.study)]
        taken.update(cell.keys)
        if left:
            seeds, keys = zip(*left, strict=True)
            missing.append(Task(cell=cell, seeds=seeds, keys=keys))
    together = [task for task in missing if task.cell.engine == "arrays"]
    alone = [one for task in missing if task.cell.engine != "arrays" for one in task.split()]
    alone.sort(key=lambda task: plan.seeds.index(task.seeds[0]))
    parts = max(1, -(-jobs // max(1, len(together))))  # few cells: each goes to several processes
    return [part for task in together for part in _parts(task, parts)] + alone


def _parts(task: Task, parts: int) -> Iterator[Task]:
    size = min(_MOST_SEEDS, -(-len(task.seeds) // parts))
    for start in range(0, len(task.seeds), size):
        some = slice(start, start + size)
        yield Task(cell=task.cell, seeds=task.seeds[some], keys=task.keys[some])


def _make(plan: Plan, store: Store, task: Task) -> None:
    cells = [plan.cell(task.cell, seed) for seed in task.seeds]
    keep_runs(cells, task.keys, task.cell.engine, plan.study.series, store)
