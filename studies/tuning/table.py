"""The trials of a search as a table: a row for each, with units."""

from __future__ import annotations

from collections.abc import Sequence

import pyarrow as pa

from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.studies.sweeps.results import unit_of_axis
from zenvoy.studies.sweeps.table import column_of, number_column, shown, titled, with_units
from zenvoy.studies.tuning.figures import FIGURES
from zenvoy.studies.tuning.study import Constraint, TuneStudy
from zenvoy.studies.tuning.trial import Trial, ranked


def table_of(study: TuneStudy, trials: Sequence[Trial]) -> pa.Table:
    """Return a row for each trial: its parameters, objective and constraints, and how it ended.

    The objective is a mean over the seeds, and a constraint has its worst value. The unit of a
    column is in its field metadata, under "unit".
    """
    columns: dict[str, tuple[pa.Array, str]] = {
        "trial": (pa.array([trial.number for trial in trials], pa.int64()), "")
    }
    for key in study.parameters:
        columns[key] = (column_of([trial.point[key] for trial in trials]), unit_of_axis(key))
    objectives = [trial.objective(study) for trial in trials]
    columns[study.figure] = (number_column(objectives), FIGURES[study.figure].unit)
    for one in study.constraints:
        if one.name not in columns:
            columns[one.name] = (number_column([_worst(one, trial) for trial in trials]), one.unit)
    columns["feasible"] = (pa.array([trial.feasible(study) for trial in trials], pa.bool_()), "")
    columns["failure"] = (pa.array([trial.failure for trial in trials], pa.string()), "")
    return with_units(columns)


def legend(study: TuneStudy) -> Sheet:
    """Return the unit and the meaning of each column of the table."""
    rows: list[tuple[Cell, ...]] = [("trial", "", "number of the trial")]
    rows += [
        (key, unit_of_axis(key), "parameter: setting of the scenario") for key in study.parameters
    ]
    meaning = FIGURES[study.figure].meaning
    rows.append((study.figure, FIGURES[study.figure].unit, f"{meaning}; mean over the seeds"))
    for one in study.constraints:
        if one.name not in {row[0] for row in rows}:
            rows.append((one.name, one.unit, f"{FIGURES[one.figure].meaning}; {_over_seeds(one)}"))
    rows.append(("feasible", "", "whether it has all figures and holds every constraint"))
    rows.append(("failure", "", "why the trial failed; null if it did not"))
    return Sheet(
        name="legend",
        title="Columns of the table.",
        columns=("column", "unit", "meaning"),
        rows=tuple(rows),
    )


def best_sheet(study: TuneStudy, trials: Sequence[Trial], most: int) -> Sheet:
    """Return the best feasible trials, the best first."""
    constraints = [one for one in study.constraints if one.name != study.figure]
    named = [
        *((key, unit_of_axis(key)) for key in study.parameters),
        (study.figure, FIGURES[study.figure].unit),
        *((one.name, one.unit) for one in constraints),
    ]
    return Sheet(
        name="best",
        title="The best trials.",
        columns=("trial", *(titled(name, unit) for name, unit in named)),
        rows=tuple(
            (
                trial.number,
                *(shown(value) for value in trial.point.values()),
                trial.objective(study),
                *(_worst(one, trial) for one in constraints),
            )
            for trial in ranked(study, trials)[:most]
        ),
        note="The objective is the mean over the seeds; constraints have their worst values.",
    )


def failures(trials: Sequence[Trial]) -> Sheet:
    """Return a row for each trial that failed, and why."""
    return Sheet(
        name="failures",
        title="Trials that failed.",
        columns=("trial", "settings", "why"),
        rows=tuple((one.number, one.settings, one.failure) for one in trials if one.failure),
    )


def _worst(constraint: Constraint, trial: Trial) -> float | None:
    values = trial.figures.get(constraint.figure)
    return constraint.worst(values) if values else None


def _over_seeds(constraint: Constraint) -> str:
    if constraint.name == constraint.figure:
        return "one value for all seeds"
    return f"{'largest' if constraint.bound == 'max' else 'smallest'} of the seeds"
