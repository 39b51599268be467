"""The files of a comparison: tables, pictures, and README.md, which says what was run."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Final

from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.section import Sheet
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.studies.comparison.compared import Comparison
from zenvoy.studies.comparison.picture import picture
from zenvoy.studies.comparison.speeds import speeds
from zenvoy.studies.comparison.table import COLUMNS, rows, section
from zenvoy.studies.sweeps.page import README, SERIES_TABLE, TABLE
from zenvoy.studies.sweeps.plan import counted
from zenvoy.studies.sweeps.settings import setting_of
from zenvoy.studies.sweeps.store import STUDY, Store
from zenvoy.studies.sweeps.table import failures, legend, parquet_bytes, table_of, write_series

LAWS: Final = "laws.csv"
_MOST_ROWS: Final = 50  # of the failures in README.md


def write_results(compared: Comparison, store: Store, command: str) -> list[Path]:
    """Write all results into the folder of the store, and return the files; raises OSError."""
    results = compared.results
    of_laws = Sheet(name="laws", title="", columns=COLUMNS, rows=tuple(rows(compared)))
    of_columns = legend(results)
    files = {TABLE: parquet_bytes(table_of(results)), LAWS: csv_bytes(of_laws)}
    files["legend.csv"] = csv_bytes(of_columns)
    drawn = [one for one in (picture(compared), speeds(compared, store)) if one is not None]
    files |= picture_files(drawn)
    lines = _what_was_run(compared, command)
    for one in drawn:
        lines += in_markdown(one)
    lines += [markdown(sheet) for sheet in section(compared).sheets]
    lines += [f"{note}\n" for note in compared.notes]
    if results.failed:
        lines += [markdown(failures(results.failed[:_MOST_ROWS]))]
    lines += [markdown(of_columns)]
    files[README] = "\n".join(lines).encode()
    series = store.folder / SERIES_TABLE
    write_series(results, store, series)
    return [*write_whole(store.folder, files), *([series] if series.exists() else [])]


def _what_was_run(compared: Comparison, command: str) -> list[str]:
    results, study = compared.results, compared.results.plan.study
    size = f"{counted(len(compared.laws), 'law')} × {counted(len(results.plan.seeds), 'seed')}"
    lines = [
        f"# Laws in `{study.scenario}`",
        "",
        f"Written by `{command}` of Zenvoy {version('zenvoy')}: {size} of the scenario"
        f" `{study.scenario}`. [{LAWS}]({LAWS}) has the figures of these tables, [{TABLE}]({TABLE})"
        f" a row for each law and seed, [{SERIES_TABLE}]({SERIES_TABLE}) the speeds of head and"
        f" tail, and [{STUDY}]({STUDY}) is the same as a study for `zenvoy sweep`.",
        "",
    ]
    if results.failed:
        lines += [f"**{len(results.failed)} of {results.plan.runs} runs failed**; see below.", ""]
    lines += ["| law | settings |", "|---|---|"]
    for law in compared.laws:
        settings = [f"`{setting_of(key, value)}`" for key, value in law.settings.items()]
        cells = [one.replace("|", r"\|") for one in (law.label, ", ".join(settings))]
        lines.append(f"| {' | '.join(cells)} |")
    if study.settings:
        lines += ["", "Settings: " + ", ".join(f"`{setting}`" for setting in study.settings) + "."]
    return [*lines, ""]
