"""Runs many scenarios, several at a time, and keeps a digest of each, so that it can resume."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

from zenvoy.analysis.log.load import load as load_log
from zenvoy.analysis.measures.digest import Digest, digest
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.run import run
from zenvoy.fleet.spawn import die_with
from zenvoy.studies.cell import Cell

_DIGEST = "digest.npz"


class StudyError(Exception):
    """A run of a study failed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """A folder of runs, the engine that makes them, and how many to make at a time."""

    folder: Path
    engine: Engine = "in-process"
    jobs: int = 1
    """Runs at a time, each in a process. The engine "processes" makes one run at a time."""
    on_line: Callable[[str], None] = field(default=lambda _: None)
    """Called with a line of text for each run that is done."""

    def run(self, cells: Sequence[Cell]) -> dict[Cell, Digest]:
        """Return a digest of each cell; make only the runs that are missing.

        Raises StudyError, ScenarioError or OSError; finished runs are kept.
        """
        folders = {cell: self.folder / cell.key() for cell in cells}
        missing = {folder: cell for cell, folder in folders.items() if _stored(folder) is None}
        self.on_line(f"{len(folders)} runs, {len(folders) - len(missing)} of them done already")
        if self.engine == "processes":  # one run alone keeps all cores busy
            for count, (folder, cell) in enumerate(missing.items(), start=1):
                _make(cell, folder, "processes")
                self._report_done(cell, count, len(missing))
        elif missing:
            self._run_pool(missing)
        return {cell: Digest.read(folder / _DIGEST) for cell, folder in folders.items()}

    def _run_pool(self, missing: dict[Path, Cell]) -> None:
        pool = ProcessPoolExecutor(
            self.jobs,
            multiprocessing.get_context("fork"),
            initializer=_be_worker,
            initargs=(os.getpid(),),
        )
        try:
            futures: dict[Future[None], Cell] = {
                pool.submit(_make, cell, folder, self.engine): cell
                for folder, cell in missing.items()
            }
            for count, future in enumerate(as_completed(futures), start=1):
                _wait_for(future, futures[future])
                self._report_done(futures[future], count, len(missing))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.kill()
            raise
        pool.shutdown()

    def _report_done(self, cell: Cell, count: int, total: int) -> None:
        self.on_line(f"{count} of {total}: {cell}")


def _stored(folder: Path) -> Digest | None:
    try:
        return Digest.read(folder / _DIGEST)
    except (OSError, ValueError, KeyError):
        return None


def _make(cell: Cell, folder: Path, engine: Engine) -> None:
    """Run a cell in `folder`, and keep only its digest there."""
    shutil.rmtree(folder, ignore_errors=True)
    loaded = cell.load()
    death = run(loaded, make_folder(folder, loaded.name), engine)
    if death is not None and not death.complete:
        raise StudyError(f"{cell.scenario}, seed {cell.seed}: {death}")
    found = digest(load_log(folder / LOG))
    shutil.rmtree(folder)
    folder.mkdir()
    found.save(folder / _DIGEST)


def _wait_for(future: Future[None], cell: Cell) -> None:
    """Wait for the end of a run; raises what it raised, and StudyError if its process died."""
    try:
        future.result()
    except BrokenExecutor as error:
        raise StudyError(
            f"{cell.scenario}, seed {cell.seed}: a process of the study died"
        ) from error


def _be_worker(parent: int) -> None:
    """Die with the parent, and leave signals from the terminal to it."""
    die_with(parent, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
