"""A sweep from a notebook: its table as a DataFrame."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import pyarrow as pa

from zenvoy.scenarios import PYTHON
from zenvoy.studies.extras import missing
from zenvoy.studies.study import StudyError
from zenvoy.studies.sweeps.sweep import Study, run_sweep
from zenvoy.studies.sweeps.table import table_of

if TYPE_CHECKING:
    from pandas import DataFrame


def sweep(
    study: Study,
    *,
    out: str | PathLike[str] | None = None,
    jobs: int | None = None,
    on_line: Callable[[str], None] = print,
    allow_code: bool = False,
    dask: str | None = None,
) -> DataFrame:
    """Run a study as `zenvoy sweep` does; return its table with a row for each cell and seed.

    `study` is the path of a study file, or a mapping with the same keys. `out` is the folder of the
    results, by default runs/<name of the study>; finished runs there are not made again. `jobs` is
    the number of runs at a time, by default one for each core. `on_line` gets a line for each run.
    Laws of your own must lie beside the scenario; with `allow_code` they may lie anywhere. `dask`
    is the address of a Dask scheduler, whose workers then make the runs. The units of the columns
    are in `DataFrame.attrs["units"]`.

    Raises BadStudyError (a ScenarioError) before anything is run; StudyError if pandas is not
    installed, or if there is no such cluster, or it is lost; or OSError.
    """
    if line := missing("pandas"):
        raise StudyError(line)
    done = run_sweep(
        study,
        out=None if out is None else Path(out),
        jobs=jobs,
        on_line=on_line,
        command="zenvoy.studies.sweep(…)",
        allow_code=allow_code,
        dask=dask,
        spelling=PYTHON,
    )
    return frame_of(table_of(done.results))


def frame_of(table: pa.Table) -> DataFrame:
    """Return a table as a DataFrame, whose `attrs["units"]` has the units of the columns."""
    frame: DataFrame = table.to_pandas()
    frame.attrs["units"] = {
        field.name: field.metadata[b"unit"].decode() for field in table.schema if field.metadata
    }
    return frame
