"""The results of a sweep as tables: Parquet with units, their legend, and the means as CSV."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from zenvoy.analysis.measures.figures import MEASURES
from zenvoy.analysis.measures.series import SERIES
from zenvoy.analysis.measures.statistics import Mean
from zenvoy.analysis.page.section import Cell, Sheet
from zenvoy.studies.sweeps.axes import Axis, Variants
from zenvoy.studies.sweeps.results import Results, Row, unit_of_axis
from zenvoy.studies.sweeps.store import Store

_COLUMNS: Final = {
    "cell": "number of the combination of the axes",
    "seed": "seed of the run",
    "failure": "why the run failed; null if it did not",
}


def table_of(results: Results) -> pa.Table:
    """Return a row for each cell and seed: `cell`, the axes, `seed`, `failure`, the measures.

    The unit of a column is in its field metadata, under "unit".
    """
    rows = results.rows
    columns: dict[str, tuple[pa.Array, str]] = {
        "cell": (pa.array([row.cell.number for row in rows], pa.int64()), "")
    }
    for key in results.plan.study.axes:
        columns[key] = (column_of([row.cell.point[key] for row in rows]), unit_of_axis(key))
    columns["seed"] = (pa.array([row.seed for row in rows], pa.int64()), "")
    columns["failure"] = (pa.array([row.failure for row in rows], pa.string()), "")
    for name in results.measures:
        columns[name] = (number_column([row.figures[name] for row in rows]), MEASURES[name].unit)
    return with_units(columns)


def parquet_bytes(table: pa.Table) -> bytes:
    """Return a table as a Parquet file; equal tables give equal bytes."""
    file = BytesIO()
    pyarrow.parquet.write_table(table, file, compression="zstd")
    return file.getvalue()


def write_series(results: Results, store: Store, path: Path) -> None:
    """Write the time series of every run that has them, run by run; raises OSError.

    A row has `cell`, the axes, `seed`, `time_s` and the series.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    writer = None
    try:
        for piece in _pieces(results, store):
            if writer is None:
                writer = pyarrow.parquet.ParquetWriter(partial, piece.schema, compression="zstd")
            writer.write_table(piece.cast(writer.schema))
        if writer is not None:
            writer.close()
            os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _pieces(results: Results, store: Store) -> Iterator[pa.Table]:
    study = results.plan.study
    every = {key: column_of([cell.point[key] for cell in results.plan.cells]) for key in study.axes}
    for row in results.rows:
        found = store.series(row.key, study.series)
        if found is None or row.failure is not None:
            continue
        length = len(found["time_s"])
        columns = {"cell": (pa.array(np.full(length, row.cell.number)), "")}
        for key, values in every.items():
            one = values[results.plan.cells.index(row.cell)]
            columns[key] = (pa.array([one] * length, values.type), unit_of_axis(key))
        columns["seed"] = (pa.array(np.full(length, row.seed)), "")
        columns["time_s"] = (pa.array(found["time_s"]), "s")
        for name in study.series:
            columns[name] = (pa.array(found[name]), SERIES[name].unit)
        yield with_units(columns)


def legend(results: Results) -> Sheet:
    """Return the unit and the meaning of each column of both tables."""
    study = results.plan.study
    rows: list[tuple[Cell, ...]] = [("cell", "", _COLUMNS["cell"])]
    rows += [(key, unit_of_axis(key), _of_axis(axis)) for key, axis in study.axes.items()]
    rows += [(name, "", _COLUMNS[name]) for name in ("seed", "failure")]
    rows += [(name, MEASURES[name].unit, MEASURES[name].meaning) for name in results.measures]
    if study.series:
        rows.append(("time_s", "s", "simulated time, in series.parquet"))
        rows += [
            (n, SERIES[n].unit, f"{SERIES[n].meaning}, in series.parquet") for n in study.series
        ]
    return Sheet(
        name="legend",
        title="Columns of the tables.",
        columns=("column", "unit", "meaning"),
        rows=tuple(rows),
    )


def _of_axis(axis: Axis) -> str:
    names = isinstance(axis, Variants)
    return "axis: name of settings" if names else "axis: setting of the scenario"


def means(results: Results) -> Sheet:
    """Return a row for each cell: means over the seeds, each with half its 95 % interval."""
    by_measure = {name: results.means(name) for name in results.measures}
    seeds: dict[int, int] = {}
    for row in results.rows:
        seeds[row.cell.number] = seeds.get(row.cell.number, 0) + (row.failure is None)
    rows = []
    for cell in results.plan.cells:
        cells: list[Cell] = [cell.number, *map(shown, cell.point.values()), seeds[cell.number]]
        for of_cells in by_measure.values():
            cells += cells_of(of_cells.get(cell.number))
        rows.append(tuple(cells))
    titles = [titled(name, MEASURES[name].unit) for name in results.measures]
    spreads = [titled("± 95 %", MEASURES[name].unit) for name in results.measures]
    axes = [titled(key, unit_of_axis(key)) for key in results.plan.study.axes]
    pairs = [title for pair in zip(titles, spreads, strict=True) for title in pair]
    return Sheet(
        name="means",
        title="Means over the seeds of each cell.",
        columns=("cell", *axes, "seeds", *pairs),
        rows=tuple(rows),
        note="± is half the 95 % confidence interval over seeds (Student's t).",
    )


def half(mean: Mean) -> float | None:
    """Return half the width of an interval; None for a single seed."""
    return None if mean.n < 2 else 0.5 * (mean.high - mean.low)


def cells_of(mean: Mean | None) -> tuple[float | None, float | None]:
    """Return a mean and half its interval for a table; None for what there is not."""
    return (None, None) if mean is None else (mean.mean, half(mean))


def shown(value: Any) -> str | int | float:
    """Return a value of an axis for people: a mapping or a list as JSON, in short."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        return json.dumps(value, ensure_ascii=False)
    return value


def titled(name: str, unit: str) -> str:
    """Return a name with its unit."""
    return f"{name}, {unit}" if unit else name


def with_units(columns: dict[str, tuple[pa.Array, str]]) -> pa.Table:
    """Return a table of columns and their units, which are in the fields' metadata."""
    fields = [
        pa.field(name, array.type, metadata={"unit": unit} if unit else None)
        for name, (array, unit) in columns.items()
    ]
    return pa.table([array for array, _ in columns.values()], schema=pa.schema(fields))


def column_of(values: list[Any]) -> pa.Array:
    """Return the values of an axis: truth values, numbers, or else text, with JSON for the rest."""
    if all(isinstance(value, bool) for value in values):
        return pa.array(values, pa.bool_())
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return number_column(values)
    return pa.array([v if isinstance(v, str) else json.dumps(v) for v in values], pa.string())


def number_column(values: list[Any]) -> pa.Array:
    """Return numbers, whole ones if all are whole; None is null."""
    known = [value for value in values if value is not None]
    whole = bool(known) and all(isinstance(value, int) for value in known)
    return pa.array(values, pa.int64() if whole else pa.float64())


def failures(rows: tuple[Row, ...]) -> Sheet:
    """Return a row for each run that failed, and why."""
    return Sheet(
        name="failures",
        title="Runs that failed.",
        columns=("cell", "settings", "seed", "why"),
        rows=tuple((r.cell.number, str(r.cell), r.seed, r.failure) for r in rows),
    )
