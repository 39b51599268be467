"""The files of a sweep: tables, pictures, and README.md, which says what was run."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Final

from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.studies.sweeps.pictures import pictures
from zenvoy.studies.sweeps.plan import counted
from zenvoy.studies.sweeps.results import Results
from zenvoy.studies.sweeps.store import STUDY, Store
from zenvoy.studies.sweeps.table import (
    failures,
    legend,
    means,
    parquet_bytes,
    shown,
    table_of,
    write_series,
)

TABLE: Final = "table.parquet"
SERIES_TABLE: Final = "series.parquet"
README: Final = "README.md"
_MOST_ROWS: Final = 50  # of a table in README.md; the files have all


def write_results(results: Results, store: Store, command: str) -> list[Path]:
    """Write all results into the folder of the store, and return the files; raises OSError."""
    study = results.plan.study
    files = {TABLE: parquet_bytes(table_of(results))}
    of_means, of_columns = means(results), legend(results)
    files |= {f"{sheet.name}.csv": csv_bytes(sheet) for sheet in (of_means, of_columns)}
    shown_pictures = pictures(results)
    files |= picture_files(shown_pictures)
    lines = _what_was_run(results, command)
    for picture in shown_pictures:
        lines += in_markdown(picture)
    if len(of_means.rows) <= _MOST_ROWS:
        lines += [markdown(of_means)]
    if results.failed:
        lines += [markdown(failures(results.failed[:_MOST_ROWS]))]
    lines += [markdown(of_columns)]
    files[README] = "\n".join(lines).encode()
    written = []
    if study.series:
        write_series(results, store, store.folder / SERIES_TABLE)
        written = [store.folder / SERIES_TABLE]
    return [*write_whole(store.folder, files), *written]


def _what_was_run(results: Results, command: str) -> list[str]:
    plan, study = results.plan, results.plan.study
    size = f"{counted(len(plan.cells), 'cell')} × {counted(len(plan.seeds), 'seed')}"
    lines = [f"# Sweep `{study.name}`", ""]
    if study.description:
        lines += [study.description, ""]
    lines += [
        f"Written by `{command}` of Zenvoy {version('zenvoy')}: {size} of"
        f" the scenario `{study.scenario}`. [{STUDY}]({STUDY}) is the study, [{TABLE}]({TABLE}) has"
        " a row for each cell and seed, and means.csv one for each cell.",
        "",
    ]
    if study.series:
        lines += [f"[{SERIES_TABLE}]({SERIES_TABLE}) has the time series of every run.", ""]
    if results.failed:
        lines += [f"**{len(results.failed)} of {plan.runs} runs failed**; see below.", ""]
    lines += ["| axis | values |", "|---|---|"]
    for key in study.axes:
        values = list(dict.fromkeys(str(shown(cell.point[key])) for cell in plan.cells))
        lines.append(f"| `{key}` | {_listed(values)} |")
    if study.settings:
        lines += ["", "Settings: " + ", ".join(f"`{setting}`" for setting in study.settings) + "."]
    return [*lines, ""]


def _listed(values: list[str]) -> str:
    if len(values) <= 12:
        return ", ".join(values)
    return f"{', '.join(values[:5])}, … {values[-1]} ({len(values)} values)"
