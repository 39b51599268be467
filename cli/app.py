"""The `zenvoy` command.

Commands import what only they need, so that `zenvoy show` does not wait for what `zenvoy run`
imports: filterpy takes more than a second.
"""

from __future__ import annotations

import signal
import sys
from enum import StrEnum
from pathlib import Path
from types import FrameType
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.table import Table

from zenvoy.scenarios import (
    Loaded,
    ScenarioError,
    builtin,
    effective_yaml,
    load,
)

EXIT_FAILED = 1
EXIT_BAD_INPUT = 2
EXIT_PROCESS_LOST = 3
EXIT_INTERRUPTED = 130

app = typer.Typer(
    name="zenvoy",
    help="Emulates convoys of vehicles that talk to each other.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
console = Console(soft_wrap=False)
errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)


class Form(StrEnum):
    """The kinds of files a log can be exported to."""

    PARQUET = "parquet"
    CSV = "csv"


class Bus(StrEnum):
    """The buses a fleet can run on."""

    ZENOH = "zenoh"
    IN_PROCESS = "in-process"


ScenarioArgument = Annotated[
    str, typer.Argument(metavar="SCENARIO", help="Name of a built-in scenario, or a file.")
]
LogArgument = Annotated[Path, typer.Argument(metavar="RUN.mcap", help="Log of a run.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value, e.g. channel.loss.p=0.3."),
]
SeedOption = Annotated[int | None, typer.Option(help="Replace the scenario's seed.")]
DurationOption = Annotated[float | None, typer.Option(help="Replace the duration, s.")]


@app.command()
def run(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: DurationOption = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run [default: runs/<time>-<scenario>].")
    ] = None,
    bus: Annotated[
        Bus, typer.Option(help="A process per vehicle on Zenoh, or all in one.")
    ] = Bus.ZENOH,
) -> None:
    """Run a scenario; leaves its log, its summary and a log per process in a folder."""
    loaded = _load(scenario, overrides, seed, duration_s)
    from zenvoy.cli.execute import execute

    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _interrupt)
    raise typer.Exit(execute(loaded, out, bus.value, console, errors))


@app.command()
def scenarios() -> None:
    """List the built-in scenarios."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column()
    for name, description in builtin():
        table.add_row(name, description)
    console.print(table)


@app.command()
def show(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: DurationOption = None,
) -> None:
    """Print the effective scenario with all defaults; itself a valid scenario file."""
    sys.stdout.write(effective_yaml(_load(scenario, overrides, seed, duration_s).scenario))


@app.command()
def check(scenario: ScenarioArgument, overrides: SetOption = None) -> None:
    """Say whether a scenario is valid, and all that is wrong with it."""
    loaded = _load(scenario, overrides, None, None)
    size, duration_s = loaded.scenario.fleet.size, loaded.scenario.duration_s
    console.print(f"{loaded.name}: valid; {size} vehicles, {duration_s:g} s", highlight=False)


@app.command()
def technologies() -> None:
    """Print the V2X technologies (the paper's Table I)."""
    from zenvoy.cli.report import print_technologies

    print_technologies(console)


@app.command()
def info(log: LogArgument) -> None:
    """Print what a log says of its run: metadata, topics, counts, fingerprint."""
    from zenvoy.analysis.log import LogError, read_facts
    from zenvoy.cli.report import print_facts

    try:
        facts = read_facts(log)
    except LogError as error:
        _refuse(str(error))
    if facts.cut:
        errors.print(f"{log}: {facts.cut}")
    print_facts(console, facts)


@app.command()
def analyze(
    log: LogArgument,
    out: Annotated[
        Path | None, typer.Option(help="Folder [default: <log>-analysis beside the log].")
    ] = None,
) -> None:
    """Tell what a log holds: summary, tables (CSV), pictures (PNG, SVG) and a report (HTML)."""
    from zenvoy.cli.analyze import analyze

    raise typer.Exit(analyze(log, out, console, errors))


@app.command()
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
    """Show runs beside each other: tables (CSV), pictures (PNG, SVG) and a page (HTML)."""
    from zenvoy.cli.analyze import compare

    raise typer.Exit(compare(logs, label or [], out, console, errors))


@app.command()
def export(
    log: LogArgument,
    to: Annotated[Form, typer.Option(help="Kind of the files.")],
    out: Annotated[Path | None, typer.Option(help="Folder [default: that of the log].")] = None,
) -> None:
    """Write the topics of a log as tables, a file each, with units in the names of columns."""
    from zenvoy.analysis import export as tables
    from zenvoy.analysis.load import load as load_log
    from zenvoy.analysis.log import LogError

    try:
        loaded = load_log(log)
        for note in loaded.notes:
            errors.print(f"{log}: {note}")
        for file in tables.export(loaded, log.parent if out is None else out, to.value):
            console.print(str(file), highlight=False, soft_wrap=True)
    except LogError as error:
        _refuse(str(error))
    except tables.ExportError as error:
        _refuse(f"--out {error}")


@app.command()
def reproduce(
    seeds: Annotated[int, typer.Option(min=2, help="Seeds of each case, from 1 on.")] = 30,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Runs at a time [default: one per core].")
    ] = None,
    bus: Annotated[
        Bus, typer.Option(help="Each run in a process, or a process per vehicle on Zenoh.")
    ] = Bus.IN_PROCESS,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("docs/reproduction"),
    runs: Annotated[
        Path, typer.Option(help="Folder of what is kept of each run; it is not run again.")
    ] = Path("runs/reproduction"),
    duration_s: DurationOption = None,
) -> None:
    """Run the paper's evaluation; leaves its tables and figures, and an answer to each claim."""
    import os

    from zenvoy.cli.reproduce import reproduce
    from zenvoy.cli.study import StudyError

    at_a_time = jobs or len(os.sched_getaffinity(0))
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _interrupt)
    try:
        reproduce(seeds, at_a_time, bus.value, out, runs, duration_s, console)
    except (StudyError, OSError) as error:
        errors.print(f"the study cannot go on: {error}")
        raise typer.Exit(EXIT_FAILED) from error


def main() -> None:
    """Entry point of the console script."""
    try:
        app()
    except KeyboardInterrupt:
        raise SystemExit(EXIT_INTERRUPTED) from None


def _load(
    scenario: str, overrides: list[str] | None, seed: int | None, duration_s: float | None
) -> Loaded:
    try:
        return load(scenario, overrides or (), seed=seed, duration_s=duration_s)
    except ScenarioError as error:
        _refuse(str(error))


def _refuse(text: str) -> NoReturn:
    errors.print(text)
    raise typer.Exit(EXIT_BAD_INPUT)


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    main()
