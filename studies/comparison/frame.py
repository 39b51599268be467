"""A comparison from a notebook: its figures as a DataFrame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

from zenvoy.scenarios import PYTHON
from zenvoy.studies.comparison.comparing import SEEDS, Comparing, run_comparison
from zenvoy.studies.comparison.table import COLUMNS, rows
from zenvoy.studies.extras import missing
from zenvoy.studies.study import StudyError

if TYPE_CHECKING:
    from pandas import DataFrame


def compare_laws(
    scenario: str | PathLike[str],
    laws: Sequence[str],
    *,
    labels: Sequence[str] = (),
    seeds: int | Sequence[int] = SEEDS,
    measures: Sequence[str] = (),
    settings: Sequence[str] = (),
    duration_s: float | None = None,
    out: str | PathLike[str] | None = None,
    jobs: int | None = None,
    on_line: Callable[[str], None] = print,
    allow_code: bool = False,
    dask: str | None = None,
) -> DataFrame:
    """Compare laws as `zenvoy compare-laws` does; return a row for each measure and law.

    `laws` are written as for the command: "PBCM", "mylaws:smith", "IDM:{headway_s: 1.5}". `labels`
    are their names in the results, one for each. `seeds` is a number of seeds or a list of them.
    `measures` are those of a sweep, `settings` have the form KEY=VALUE. `out` is the folder of the
    results, by default runs/<name of the scenario>-laws; finished runs there are not made again.
    For the other arguments see `sweep`.

    The columns are measure, unit, law, seeds (how many have the measure), mean, half_interval (of
    95 % confidence), difference (from the first law, seed by seed) and half_interval_of_difference.

    Raises BadStudyError (a ScenarioError) before anything is run; StudyError if pandas is not
    installed, or if there is no such cluster, or it is lost; or OSError.
    """
    if line := missing("pandas"):
        raise StudyError(line)
    import pandas  # an extra

    asked = Comparing(
        scenario=fspath(scenario),
        laws=laws,
        labels=labels,
        seeds=seeds,
        measures=measures,
        settings=settings,
        duration_s=duration_s,
        allow_code=allow_code,
        spelling=PYTHON,
    )
    done = run_comparison(
        asked,
        out=None if out is None else Path(out),
        jobs=jobs,
        on_line=on_line,
        command="zenvoy.studies.compare_laws(…)",
        dask=dask,
    )
    return pandas.DataFrame(rows(done.comparison), columns=list(COLUMNS))
