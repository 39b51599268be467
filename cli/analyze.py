"""`zenvoy analyze` and `zenvoy compare`, from logs to files and the exit code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console

from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.overview import overview_section
from zenvoy.analysis.chapters.recorded import recorded_section
from zenvoy.analysis.compare.comparison import Compared, comparison_page
from zenvoy.analysis.log.arrays import LogError
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.html import Page, render
from zenvoy.analysis.page.report import report_page
from zenvoy.analysis.page.section import Section
from zenvoy.bus.clock import stamp
from zenvoy.bus.text import utf8
from zenvoy.cli import exits
from zenvoy.cli.labels import LabelError, labels_for
from zenvoy.cli.report import print_summary
from zenvoy.cli.sections import print_section
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import Problem, ScenarioError
from zenvoy.scenarios.convoys.cutting import Choice
from zenvoy.scenarios.convoys.errors import ConvoyError
from zenvoy.scenarios.convoys.reading import read_convoy


class OutError(Exception):
    """The output folder cannot be made."""


def analyze(
    log: Path, out: Path | None, console: Console, errors: Console, recorded: Path | None = None
) -> int:
    """Print the summary and chapters of a log, and write its report; return the exit code.

    `recorded` is a recording to compare with, as an import has kept it.
    """
    try:
        run = _with_motion(log)
        real = () if recorded is None else (_beside_recording(run, recorded),)
        folder = folder_for(log.parent / f"{log.stem}-analysis" if out is None else out)
        for note in run.notes:
            errors.print(f"{log}: {note}")
        with damage_as_log_error(run):
            summary, sections = summary_of(run), (*real, *chapters(run))

            def print_result() -> None:
                print_summary(console, summary, spacing_of(run.scenario))
                for section in sections:
                    print_section(console, section)

            page = report_page(run, (overview_section(run, summary), *sections))
            return write_page(page, "report.html", folder, console, errors, print_result)
    except (LogError, OutError, ScenarioError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT


def _beside_recording(run: Run, recorded: Path) -> Section:
    """Return the chapter that compares a run with a recording; raises ScenarioError."""
    convoy = read_convoy(recorded, Choice())
    try:
        return recorded_section(run, convoy)
    except ValueError as error:
        raise ConvoyError([Problem(key=f"--recorded {recorded}", text=str(error))]) from None


def compare(
    logs: list[Path], labels: list[str], out: Path | None, console: Console, errors: Console
) -> int:
    """Print a comparison of runs, and write it as a page with files; return the exit code."""
    try:
        named = labels_for(logs, labels)
        runs = [_with_motion(log) for log in logs]
        folder = folder_for(Path("runs") / f"{stamp()}-comparison" if out is None else out)
        with damage_as_log_error(*runs):
            compared = [
                Compared(label=label, run=run, summary=summary_of(run))
                for label, run in zip(named, runs, strict=True)
            ]
            page = comparison_page(compared)
            for note in page.notes:
                errors.print(note)

            def print_result() -> None:
                for name, value in page.facts:
                    console.print(f"{name}: {value}")
                for section in page.sections:
                    print_section(console, section)

            return write_page(page, "compare.html", folder, console, errors, print_result)
    except (LogError, OutError, LabelError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT


def _with_motion(log: Path) -> Run:
    """Load the run of a log; raises LogError if there is no motion to show."""
    run = load(log)
    if len(run.time_s) < 2 or not run.cycles:
        reasons = dict.fromkeys([*run.notes, "no cycle was logged"])
        raise LogError(f"{log}: nothing to show: {'; '.join(reasons)}")
    return run


@contextmanager
def damage_as_log_error(*runs: Run) -> Iterator[None]:
    """Turn an error of the analysis into a LogError if a log fails its checks.

    The numbers in a damaged log can be anything, so that any calculation with them may fail.
    """
    try:
        yield
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        for run in runs:
            if any(check.holds is False for check in run.checks):
                what = f"{type(error).__name__}: {error}".splitlines()[0]
                raise LogError(f"{run.log}: too damaged to be analysed: {what}") from error
        raise


def folder_for(folder: Path) -> Path:
    """Make the folder if it does not exist, and return it; raises OutError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutError(f"--out {folder}: {error.strerror}") from error
    return folder


def write_page(
    page: Page,
    name: str,
    folder: Path,
    console: Console,
    errors: Console,
    print_result: Callable[[], None],
) -> int:
    """Write a page with its pictures and tables, print the result and the paths of the files.

    Return the exit code.
    """
    pictures = [picture for section in page.sections for picture in section.pictures]
    sheets = [sheet for section in page.sections for sheet in section.sheets]
    forms = {picture.name: drawn(picture) for picture in pictures}
    files = {f"{sheet.name}.csv": csv_bytes(sheet) for sheet in sheets}
    for stem, form in forms.items():
        files |= {f"{stem}.png": form.png, f"{stem}.svg": form.svg}
    files[name] = utf8(render(page, forms))
    failure = None
    try:
        with interruptible():
            write_whole(folder, files)
    except OSError as error:
        failure = error.strerror
    print_result()
    if failure is not None:
        errors.print(f"{folder}: cannot write: {failure}")
        return exits.FAILED
    console.print()
    for path in _paths(folder, files):
        console.print(path, soft_wrap=True)
    return exits.OK


def _paths(folder: Path, files: Iterable[str]) -> list[str]:
    """Return the paths in shell notation, files of one stem in one line, the page last."""
    kinds: dict[str, list[str]] = {}
    for name in files:
        stem, _, kind = name.rpartition(".")
        kinds.setdefault(stem, []).append(kind)
    return [
        f"{folder / stem}." + (of[0] if len(of) == 1 else f"{{{','.join(of)}}}")
        for stem, of in kinds.items()
    ]
