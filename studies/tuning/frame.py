"""A search from a notebook: its trials as a DataFrame."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from zenvoy.scenarios import PYTHON
from zenvoy.studies.extras import missing
from zenvoy.studies.study import StudyError
from zenvoy.studies.sweeps.frame import frame_of
from zenvoy.studies.sweeps.sweep import Study

if TYPE_CHECKING:
    from pandas import DataFrame


def tune(
    study: Study,
    *,
    out: str | PathLike[str] | None = None,
    jobs: int | None = None,
    on_line: Callable[[str], None] = print,
    allow_code: bool = False,
) -> DataFrame:
    """Search as `zenvoy tune` does; return a table with a row for each trial.

    `study` is the path of a study file, or a mapping with the same keys. `out` is the folder of the
    results, by default runs/<name of the study>; finished trials there are not made again. `jobs`
    is the number of processes for the seeds of a trial, by default one for each core. `on_line`
    gets a line for each trial. Laws of your own must lie beside the scenario; with `allow_code`
    they may lie anywhere. The units of the columns are in `DataFrame.attrs["units"]`, and the
    number of the best trial is in `DataFrame.attrs["best"]`, None if none is feasible. Raises
    BadStudyError (a ScenarioError) before anything is run, StudyError if Optuna or pandas is not
    installed, or OSError.
    """
    if line := missing("optuna", "pandas"):
        raise StudyError(line)
    from zenvoy.studies.tuning.table import table_of
    from zenvoy.studies.tuning.tune import run_tune

    done = run_tune(
        study,
        out=None if out is None else Path(out),
        jobs=jobs,
        on_line=on_line,
        command="zenvoy.studies.tune(…)",
        allow_code=allow_code,
        spelling=PYTHON,
    )
    frame = frame_of(table_of(done.study, done.trials))
    frame.attrs["best"] = None if done.best is None else done.best.number
    return frame
