"""The files of a search: the table, the best scenario, pictures, and README.md."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from shlex import quote
from typing import Final

from zenvoy.analysis.page.drawing import in_markdown, picture_files
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.paper.reproduction import markdown
from zenvoy.studies.sweeps.page import README
from zenvoy.studies.sweeps.plan import counted
from zenvoy.studies.sweeps.store import STUDY
from zenvoy.studies.sweeps.table import parquet_bytes
from zenvoy.studies.tuning.best import best_yaml, cell_of
from zenvoy.studies.tuning.figures import FIGURES
from zenvoy.studies.tuning.pictures import pictures
from zenvoy.studies.tuning.storage import TRIALS
from zenvoy.studies.tuning.study import TuneStudy
from zenvoy.studies.tuning.table import best_sheet, failures, legend, table_of
from zenvoy.studies.tuning.trial import Trial, best_of

TABLE: Final = "trials.parquet"
BEST: Final = "best.yaml"
_MOST_BEST: Final = 10
_MOST_FAILURES: Final = 50


def write_results(
    study: TuneStudy, trials: Sequence[Trial], folder: Path, command: str
) -> list[Path]:
    """Write all results into the folder, and return the files; raises OSError."""
    best = best_of(study, trials)
    scenario = None if best is None else best_yaml(study, best, folder)
    files = {TABLE: parquet_bytes(table_of(study, trials))}
    if scenario is None:
        (folder / BEST).unlink(missing_ok=True)
    else:
        files[BEST] = scenario
    files["legend.csv"] = csv_bytes(legend(study))
    lines = _what_was_run(study, trials, command) + _what_is_best(study, best, scenario)
    shown_pictures = pictures(study, trials)
    files |= picture_files(shown_pictures)
    for picture in shown_pictures:
        lines += in_markdown(picture)
    if best is not None:
        lines += [markdown(best_sheet(study, trials, _MOST_BEST))]
    failed = [trial for trial in trials if trial.failure]
    if failed:
        lines += [markdown(failures(failed[:_MOST_FAILURES]))]
    lines += [markdown(legend(study))]
    files[README] = "\n".join(lines).encode()
    return write_whole(folder, files)


def _what_was_run(study: TuneStudy, trials: Sequence[Trial], command: str) -> list[str]:
    runs = study.runs
    size = f"{counted(len(trials), 'trial')} × {counted(len(study.seeds), 'seed')}"
    lines = [f"# Search `{study.name}`", ""]
    if runs.description:
        lines += [runs.description, ""]
    lines += [
        f"Written by `{command}` of Zenvoy {version('zenvoy')}: {size} of the scenario"
        f" `{runs.scenario}`. [{STUDY}]({STUDY}) is the study, [{TABLE}]({TABLE}) has a row for"
        f" each trial, and {TRIALS} keeps them for Optuna.",
        "",
        f"The search {study.direction}s `{study.figure}` ({FIGURES[study.figure].meaning})"
        f"{_under(study)}.",
        "",
    ]
    feasible = sum(trial.feasible(study) for trial in trials)
    out = sum(not trial.failure and trial.objective(study) is None for trial in trials)
    failed = sum(trial.failure is not None for trial in trials)
    lines += [
        f"{feasible} of {counted(len(trials), 'trial')} are feasible; {out} were ruled out"
        f" before they had a value, and {failed} failed.",
        "",
        "| parameter | values |",
        "|---|---|",
        *(f"| `{key}` | {one.shown} |" for key, one in study.parameters.items()),
    ]
    if runs.settings:
        lines += ["", "Settings: " + ", ".join(f"`{setting}`" for setting in runs.settings) + "."]
    return [*lines, ""]


def _under(study: TuneStudy) -> str:
    if not study.constraints:
        return ""
    return " under " + ", ".join(f"`{constraint}`" for constraint in study.constraints)


def _what_is_best(study: TuneStudy, best: Trial | None, scenario: bytes | None) -> list[str]:
    if best is None:
        return ["**No trial is feasible.**", ""]
    cell = cell_of(study, best)
    settings = " ".join(f"--set {quote(setting)}" for setting in cell.settings)
    duration = "" if cell.duration_s is None else f" --duration-s {cell.duration_s:g}"
    command = f"zenvoy run {quote(cell.scenario)} {settings} --seed {cell.seed}{duration}"
    command += " --allow-code" * cell.allow_code
    unit = FIGURES[study.figure].unit
    lines = [
        f"**Trial {best.number} is the best**, with `{study.figure}`"
        f" {best.objective(study):.6g}{f' {unit}' if unit else ''}:",
        "",
        *(f"- `{setting}`" for setting in best.as_settings),
        "",
    ]
    if scenario is not None:
        lines += [f"[{BEST}]({BEST}) is its scenario. This command runs it, too:", ""]
    else:
        lines += ["This command runs it:", ""]
    return [*lines, "```sh", command, "```", ""]
