"""Runs the seeds of a cell, and keeps a summary of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.series import SERIES
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.bus.topics import ESTIMATE, RADAR, TRUTH
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, make_folder
from zenvoy.fleet.run import run
from zenvoy.scenarios import Loaded
from zenvoy.studies.batches import run_batch
from zenvoy.studies.cell import Cell
from zenvoy.studies.study import StudyError
from zenvoy.studies.sweeps.store import Store

_PREFIX: Final = "zenvoy-sweep-"

# The columns from which the summary and the time series of a run are computed.
_WANTED: Final[Mapping[str, Sequence[str]]] = {
    TRUTH.log_name: ("position", "speed", "acceleration"),
    RADAR.log_name: ("speed", "gap"),
    ESTIMATE.log_name: ("speed", "ahead_gap"),
}


def keep_runs(
    cells: Sequence[Cell], keys: Sequence[str], engine: Engine, series: Sequence[str], store: Store
) -> None:
    """Run cells that differ only in their seed, and store each under its key when it is done.

    Raises StudyError, LawError, ScenarioError, LogError or OSError; finished runs are kept.
    """
    keep_loaded([cell.load() for cell in cells], keys, engine, series, store)


def keep_loaded(
    scenarios: Sequence[Loaded],
    keys: Sequence[str],
    engine: Engine,
    series: Sequence[str],
    store: Store,
) -> None:
    """Do what `keep_runs` does, but with loaded scenarios."""
    for key, found in zip(keys, runs_of(scenarios, engine), strict=True):
        values = {name: SERIES[name].of(found) for name in series}
        store.write(key, summary_of(found), {"time_s": found.time_s, **values} if series else {})


def runs_of(scenarios: Sequence[Loaded], engine: Engine) -> Iterator[Run]:
    """Yield the runs of scenarios that differ only in their seed; logs are deleted."""
    if engine == "arrays":
        yield from run_batch(scenarios, _WANTED)
        return
    for loaded in scenarios:
        with TemporaryDirectory(prefix=_PREFIX) as folder:
            yield _logged(loaded, Path(folder) / "run", engine)


def _logged(loaded: Loaded, folder: Path, engine: Engine) -> Run:
    death = run(loaded, make_folder(folder, loaded.name), engine)
    if death is not None and not death.complete:
        raise StudyError(str(death))
    return load(folder / LOG)
