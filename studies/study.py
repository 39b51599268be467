"""Runs many scenarios, several at a time, and keeps a digest of each, so that it can resume."""

from __future__ import annotations

import shutil
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

from zenvoy.analysis.log.load import load as load_log
from zenvoy.analysis.measures.digest import COLUMNS, Digest, digest
from zenvoy.fleet.arrays.covered import NotCoveredError, uncovered
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.requests import requests_held
from zenvoy.fleet.run import run
from zenvoy.laws.errors import LawError
from zenvoy.scenarios import Loaded, Scenario
from zenvoy.studies.batches import parts, run_batch
from zenvoy.studies.cell import Cell, key_of
from zenvoy.studies.worker import worker_pool

_DIGEST = "digest.npz"


class StudyError(Exception):
    """A run of a study failed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """The work of a process: runs that differ only in their seed, and their engine."""

    engine: Engine
    cells: Sequence[Cell]
    runs: Sequence[Loaded]
    folders: Sequence[Path]
    fingerprints: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A folder of runs, the engine that makes them, and how many to make at a time."""

    folder: Path
    engine: Engine = "arrays"
    """With "arrays", runs that arrays do not support run in process."""
    jobs: int = 1
    """The number of processes at a time. Each makes one run, or on arrays the runs that differ only
    in their seed. The engine "processes" makes one run at a time."""
    fingerprints: bool = False
    """Whether runs on arrays also get fingerprints."""
    on_line: Callable[[str], None] = field(default=lambda _: None)
    """Called with a line of text for each run that is done."""

    def run(self, cells: Sequence[Cell]) -> dict[Cell, Digest]:
        """Return a digest of each cell; make only the runs that are missing.

        Raises StudyError, ScenarioError or OSError; finished runs are kept.
        """
        loaded = {cell: cell.load() for cell in cells}
        folders = {cell: self.folder / key_of(one.scenario) for cell, one in loaded.items()}
        missing = {
            folder: (cell, loaded[cell])
            for cell, folder in folders.items()
            if not self._is_done(folder)
        }
        self.on_line(f"{len(folders)} runs, {len(folders) - len(missing)} of them done already")
        if missing:
            self.on_line(f"engine: {self.engine}")
        tasks = list(self._tasks(missing))
        if self.engine == "processes":  # one run alone keeps all cores busy
            self._report(tasks, ((task, _make(task)) for task in tasks))
        elif missing:
            self._run_pool(tasks)
        return {cell: Digest.read(folder / _DIGEST) for cell, folder in folders.items()}

    def _is_done(self, folder: Path) -> bool:
        found = _stored(folder)
        if found is None:
            return False
        return bool(found.facts["fingerprint"]) or not self.fingerprints

    def _tasks(self, missing: Mapping[Path, tuple[Cell, Loaded]]) -> Iterator[Task]:
        alike: dict[str, list[Path]] = defaultdict(list)
        for number, (folder, (cell, loaded)) in enumerate(missing.items()):
            why = uncovered(loaded.scenario) if self.engine == "arrays" else []
            for line in why:
                self.on_line(f"{cell}: in-process, for {line}")
            together = self.engine == "arrays" and not why
            alike[_without_seed(loaded.scenario) if together else str(number)].append(folder)
        for key, folders in alike.items():
            engine: Engine = self.engine
            if engine == "arrays" and key.isdecimal():
                engine = "in-process"
            runs = {missing[folder][1].scenario.seed: folder for folder in folders}
            for part in parts([missing[folder][1] for folder in folders], COLUMNS):
                some = [runs[loaded.scenario.seed] for loaded in part]
                yield Task(
                    engine=engine,
                    cells=[missing[folder][0] for folder in some],
                    runs=part,
                    folders=some,
                    fingerprints=self.fingerprints,
                )

    def _run_pool(self, tasks: Sequence[Task]) -> None:
        with worker_pool(self.jobs) as pool:
            futures: dict[Future[str], Task] = {}
            for task in tasks:
                with requests_held():  # the pool forks its workers here
                    futures[_submitted(pool, task)] = task
            done = ((futures[one], _result_of(one, futures[one])) for one in as_completed(futures))
            self._report(tasks, done)

    def _report(self, tasks: Sequence[Task], done: Iterable[tuple[Task, str]]) -> None:
        total, count = sum(len(task.cells) for task in tasks), 0
        for task, note in done:
            if note:
                self.on_line(note)
            for cell in task.cells:
                count += 1
                self.on_line(f"{count} of {total}: {cell}")


def _without_seed(scenario: Scenario) -> str:
    """Return a text that is equal for scenarios that differ only in their seed."""
    return scenario.model_dump_json(exclude_defaults=True, exclude={"seed", "description"})


def _stored(folder: Path) -> Digest | None:
    try:
        return Digest.read(folder / _DIGEST)
    except (OSError, ValueError, KeyError):
        return None


def _make(task: Task) -> str:
    """Run the cells of a task, and keep only the digest of each; return a note, or ""."""
    if task.engine != "arrays":
        return _make_each(task, task.engine)
    try:
        found = run_batch(task.runs, COLUMNS, fingerprints=task.fingerprints)
        for folder, one in zip(task.folders, found, strict=True):
            _keep(digest(one), folder)
    except LawError:  # run the cells one by one, to name the one that fails
        return _make_each(task, "in-process")
    except NotCoveredError as error:
        _make_each(task, "in-process")
        return f"{task.cells[0]} and others that differ in their seed: in-process, for {error}"
    return ""


def _make_each(task: Task, engine: Engine) -> str:
    for cell, loaded, folder in zip(task.cells, task.runs, task.folders, strict=True):
        _make_logged(cell, loaded, folder, engine)
    return ""


def _make_logged(cell: Cell, loaded: Loaded, folder: Path, engine: Engine) -> None:
    """Run a cell in `folder`, and keep only its digest there."""
    shutil.rmtree(folder, ignore_errors=True)
    death = run(loaded, make_folder(folder, loaded.name), engine)
    if death is not None and not death.complete:
        raise StudyError(f"{cell.scenario}, seed {cell.seed}: {death}")
    _keep(digest(load_log(folder / LOG)), folder)


def _keep(found: Digest, folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    found.save(folder / _DIGEST)


def _submitted(pool: ProcessPoolExecutor, task: Task) -> Future[str]:
    """Hand a task to the pool; raises StudyError if one of its processes has died by now."""
    try:
        return pool.submit(_make, task)
    except BrokenExecutor as error:
        raise _died(task) from error


def _died(task: Task) -> StudyError:
    cell = task.cells[0]
    return StudyError(f"{cell.scenario}, seed {cell.seed}: a process of the study died")


def _result_of(future: Future[str], task: Task) -> str:
    """Return what a task returned; raises what it raised, and StudyError if its process died."""
    try:
        return future.result()
    except BrokenExecutor as error:
        raise _died(task) from error
