"""`zenvoy analyze` and `zenvoy compare` from logs to files and an exit code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console

from zenvoy.analysis.chapters.contents import chapters
from zenvoy.analysis.chapters.overview import overview_section
from zenvoy.analysis.compare.comparison import Compared, comparison_page
from zenvoy.analysis.log.arrays import LogError
from zenvoy.analysis.log.load import Run, load
from zenvoy.analysis.measures.summary import summary_of
from zenvoy.analysis.page.drawing import drawn
from zenvoy.analysis.page.files import csv_bytes, write_whole
from zenvoy.analysis.page.html import Page, render
from zenvoy.analysis.page.report import report_page
from zenvoy.bus.clock import stamp
from zenvoy.bus.text import utf8
from zenvoy.cli import exits
from zenvoy.cli.labels import LabelError, labels_for
from zenvoy.cli.report import print_summary
from zenvoy.cli.sections import print_section
from zenvoy.fleet.requests import interruptible


class OutError(Exception):
    """What is to hold the files cannot."""


def analyze(log: Path, out: Path | None, console: Console, errors: Console) -> int:
    """Print what a log tells, and leave its report, tables and pictures; the exit code."""
    try:
        run = _with_motion(log)
        folder = folder_for(log.parent / f"{log.stem}-analysis" if out is None else out)
        for note in run.notes:
            errors.print(f"{log}: {note}")
        with bearing(run):
            summary, told = summary_of(run), chapters(run)

            def tell() -> None:
                print_summary(console, summary)
                for section in told:
                    print_section(console, section)

            page = report_page(run, (overview_section(run, summary), *told))
            return leave(page, "report.html", folder, console, errors, tell)
    except (LogError, OutError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT


def compare(
    logs: list[Path], labels: list[str], out: Path | None, console: Console, errors: Console
) -> int:
    """Print what differs between runs, and leave it as page, tables and pictures; the exit code."""
    try:
        named = labels_for(logs, labels)
        runs = [_with_motion(log) for log in logs]
        folder = folder_for(Path("runs") / f"{stamp()}-comparison" if out is None else out)
        with bearing(*runs):
            compared = [
                Compared(label=label, run=run, summary=summary_of(run))
                for label, run in zip(named, runs, strict=True)
            ]
            page = comparison_page(compared)
            for note in page.notes:
                errors.print(note)

            def tell() -> None:
                for name, value in page.facts:
                    console.print(f"{name}: {value}")
                for section in page.sections:
                    print_section(console, section)

            return leave(page, "compare.html", folder, console, errors, tell)
    except (LogError, OutError, LabelError) as error:
        errors.print(str(error))
        return exits.BAD_INPUT


def _with_motion(log: Path) -> Run:
    """The run of a log; raises LogError where there is no motion to show."""
    run = load(log)
    if len(run.time_s) < 2 or not run.cycles:
        reasons = dict.fromkeys([*run.notes, "no cycle was logged"])
        raise LogError(f"{log}: nothing to show: {'; '.join(reasons)}")
    return run


@contextmanager
def bearing(*runs: Run) -> Iterator[None]:
    """Raise LogError for what an analysis cannot bear of a log that fails its checks.

    Nothing is promised of numbers that are not those of the run, but a line that says so.
    """
    try:
        yield
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        for run in runs:
            if any(check.holds is False for check in run.checks):
                what = f"{type(error).__name__}: {error}".splitlines()[0]
                raise LogError(f"{run.path}: too damaged to be analysed: {what}") from error
        raise


def folder_for(folder: Path) -> Path:
    """The folder, made where it is not there; raises OutError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutError(f"--out {folder}: {error.strerror}") from error
    return folder


def leave(
    page: Page,
    name: str,
    folder: Path,
    console: Console,
    errors: Console,
    tell: Callable[[], None],
) -> int:
    """Draw and write every file, then tell what there is to tell, and where they are."""
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
    tell()
    if failure is not None:
        errors.print(f"{folder}: cannot be written to: {failure}")
        return exits.FAILED
    console.print()
    for path in _paths(folder, files):
        console.print(path, soft_wrap=True)
    return exits.OK


def _paths(folder: Path, files: Iterable[str]) -> list[str]:
    """Where files are, as a shell would take it: those of one stem together, the page last."""
    kinds: dict[str, list[str]] = {}
    for name in files:
        stem, _, kind = name.rpartition(".")
        kinds.setdefault(stem, []).append(kind)
    return [
        f"{folder / stem}." + (of[0] if len(of) == 1 else f"{{{','.join(of)}}}")
        for stem, of in kinds.items()
    ]
