"""The commands that read logs.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.fleet.requests import interruptible


class Form(StrEnum):
    """The kinds of files a log can be exported to."""

    PARQUET = "parquet"
    CSV = "csv"


LogArgument = Annotated[Path, typer.Argument(metavar="RUN.mcap", help="Log of a run.")]


def info(
    log: LogArgument,
    verify: Annotated[
        bool,
        typer.Option("--verify", help="Print each check of the log; exit with 1 if one fails."),
    ] = False,
) -> None:
    """Print metadata, topics and counts of a log."""
    from zenvoy.analysis.log.arrays import LogError, read_facts
    from zenvoy.cli.report import print_checks, print_facts

    try:
        facts = read_facts(log)
    except LogError as error:
        refuse(str(error))
    for note in (*([facts.cut] if facts.cut else []), *facts.faults):
        errors.print(f"{log}: {note}")
    print_facts(console, facts)
    if verify:
        print_checks(console, facts.checks)
        if any(check.holds is False for check in facts.checks):
            raise typer.Exit(exits.FAILED)


def analyze(
    log: LogArgument,
    out: Annotated[
        Path | None, typer.Option(help="Folder [default: <log>-analysis beside the log].")
    ] = None,
    recorded: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="Import of a convoy, to compare its cars with."),
    ] = None,
) -> None:
    """Print a summary of a log and write a report.

    Writes tables (CSV), pictures (PNG, SVG) and a report (HTML).
    """
    from zenvoy.cli.analyze import analyze

    raise typer.Exit(analyze(log, out, console, errors, recorded))


def compare(
    logs: Annotated[list[Path], typer.Argument(metavar="RUN.mcap...", help="Logs, two or more.")],
    label: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Name of a run; once for each, in order."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder [default: runs/<time>-comparison].")
    ] = None,
) -> None:
    """Compare runs side by side.

    Writes tables (CSV), pictures (PNG, SVG) and a page (HTML).
    """
    from zenvoy.cli.analyze import compare

    raise typer.Exit(compare(logs, label or [], out, console, errors))


def export(
    log: LogArgument,
    to: Annotated[Form, typer.Option(help="Format of the files.")],
    out: Annotated[Path | None, typer.Option(help="Folder [default: that of the log].")] = None,
) -> None:
    """Export each topic of a log as a table.

    Writes a file per topic, with units in the column names.
    """
    from zenvoy.analysis.log import export as tables
    from zenvoy.analysis.log.arrays import LogError
    from zenvoy.analysis.log.load import load as load_log

    try:
        loaded = load_log(log)
        for note in loaded.notes:
            errors.print(f"{log}: {note}")
        with interruptible():
            files = tables.export(loaded, log.parent if out is None else out, to.value)
    except LogError as error:
        refuse(str(error))
    except tables.ExportError as error:
        refuse(f"--out {error}")
    for file in files:
        console.print(str(file), soft_wrap=True)


def repair(
    log: LogArgument,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The new log [default: <log>-repaired.mcap beside it]."),
    ] = None,
    salvage: Annotated[
        bool, typer.Option("--salvage", help="Also read past damaged parts.")
    ] = False,
) -> None:
    """Write a complete log from one that is cut.

    The original stays as it is.
    """
    from zenvoy.cli.repair import repair_log

    with interruptible():
        code = repair_log(log, out, salvage, console, errors)
    raise typer.Exit(code)


LOG_COMMANDS = (info, analyze, compare, export, repair)
