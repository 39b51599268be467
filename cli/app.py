"""The `zenvoy` command.

Commands import what only they need, so that `zenvoy show` does not wait for what `zenvoy run`
imports: filterpy takes more than a second.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from zenvoy.cli import exits
from zenvoy.cli.log_commands import COMMANDS
from zenvoy.cli.streams import settle
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.cli.usage import App
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import (
    Control,
    Loaded,
    ScenarioError,
    builtin,
    effective_yaml,
    load,
)
from zenvoy.scenarios.reading.library import packaged

app = App(
    name="zenvoy",
    help="Emulates convoys of vehicles that talk to each other.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


class Bus(StrEnum):
    """The buses a fleet can run on."""

    ZENOH = "zenoh"
    IN_PROCESS = "in-process"


def engine_of(bus: Bus) -> Engine:
    """Return what the option says."""
    return "processes" if bus is Bus.ZENOH else "in-process"


def _begun(text: str) -> list[str]:
    """Built-in scenarios for a shell to complete; where there are none it looks for files."""
    return [name for name in packaged() if name.startswith(text)]


ScenarioArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="Name of a built-in scenario, or a file.",
        autocompletion=_begun,
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value, e.g. channel.loss.p=0.3."),
]
SeedOption = Annotated[int | None, typer.Option(help="Replace the scenario's seed.")]
DurationOption = Annotated[float | None, typer.Option(help="Replace the duration, s.")]
StrictOption = Annotated[
    bool, typer.Option("--strict", help="Refuse what is allowed, and hardly meant.")
]


def _print_version(asked: bool) -> None:
    if asked:
        console.print(f"zenvoy {version_of('zenvoy')}")
        raise typer.Exit


@app.callback()
def zenvoy(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and exit.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """What stands before a command."""


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
    realtime: Annotated[
        bool, typer.Option("--realtime", help="On the wall clock, not as fast as possible.")
    ] = False,
    speed: Annotated[
        float | None, typer.Option(help="In real time: simulated over wall time, 0.1 to 10.")
    ] = None,
    per_process: Annotated[
        int, typer.Option("--vehicles-per-process", help="How many neighbours share a process.")
    ] = 1,
    without: Annotated[
        list[int] | None,
        typer.Option(metavar="ID", help="A vehicle that another program is to be; repeatable."),
    ] = None,
    listen: Annotated[
        list[str] | None,
        typer.Option(
            metavar="tcp/HOST:PORT",
            help="Where the world listens too, and the channel at the next port; repeatable.",
        ),
    ] = None,
    strict: StrictOption = False,
) -> None:
    """Run a scenario; leaves its log, its summary and a log per process in a folder."""
    clock = "realtime" if realtime else None
    loaded = _load(scenario, overrides, seed, duration_s, clock=clock, speed=speed)
    if loaded.scenario.clock == "realtime" and bus is Bus.IN_PROCESS:
        refuse(f"clock: realtime is for a process per vehicle; allowed: --bus {Bus.ZENOH.value}")
    if per_process < 1:
        refuse(f"--vehicles-per-process {per_process}: is not at least 1")
    if (without or listen or per_process > 1) and bus is Bus.IN_PROCESS:
        refuse(
            "--without, --listen and --vehicles-per-process are for processes: "
            f"--bus {Bus.ZENOH.value}"
        )
    from zenvoy.fleet.guests import GuestsError, guests

    try:
        others = guests(without or (), listen or (), loaded.scenario.fleet.size)
    except GuestsError as error:
        refuse(str(error))
    _tell_notes(loaded, strict)
    from zenvoy.cli.execute import execute

    with interruptible():
        code = execute(loaded, out, engine_of(bus), console, errors, others, per_process)
    raise typer.Exit(code)


@app.command()
def vehicle(
    vehicle: Annotated[int, typer.Option("--id", help="Number of the vehicle, from 1 on.")],
    run: Annotated[
        str, typer.Option(help="Folder of the run; or its name, where --connect says where it is.")
    ],
    connect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT", help="Where the world listens, and again, where the channel does."
        ),
    ] = None,
    timeout_s: Annotated[
        float, typer.Option(help="How long to wait for the run to answer, s [0.1 to 86400].")
    ] = 10.0,
) -> None:
    """Join a run in place of a vehicle that is missing."""
    from zenvoy.cli.join import join

    with interruptible():
        code = join(vehicle, run, connect or (), timeout_s, console, errors)
    os._exit(settle(code))  # a session that is open would keep the interpreter from leaving


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
    shown = _load(scenario, overrides, seed, duration_s).scenario
    # Scenarios are UTF-8, and so is what is shown of one, or else of ASCII alone.
    utf = sys.stdout.encoding.lower().startswith("utf")
    sys.stdout.write(effective_yaml(shown, ascii_only=not utf))


@app.command()
def check(
    scenario: ScenarioArgument, overrides: SetOption = None, strict: StrictOption = False
) -> None:
    """Say whether a scenario is valid, and all that is wrong with it."""
    loaded = _load(scenario, overrides, None, None)
    _tell_notes(loaded, strict)
    size, duration_s = loaded.scenario.fleet.size, loaded.scenario.duration_s
    console.print(f"{loaded.name}: valid; {size} vehicles, {duration_s:g} s", soft_wrap=True)


@app.command()
def technologies() -> None:
    """Print the V2X technologies (the paper's Table I)."""
    from zenvoy.cli.report import print_technologies

    print_technologies(console)


@app.command()
def channel(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: Annotated[float, typer.Option(help="How long to look at it, s.")] = 60.0,
    out: Annotated[Path | None, typer.Option(help="Folder [default: runs/<time>-channel].")] = None,
) -> None:
    """Draw what the channel of a scenario does to beacons: latency, loss, bursts, age."""
    from zenvoy.cli.channel import channel

    raise typer.Exit(channel(_load(scenario, overrides, seed, duration_s), out, console, errors))


@app.command()
def trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of times and speeds.")],
    column: Annotated[str | None, typer.Option(help="Column of speeds, by name.")] = None,
    time_column: Annotated[str | None, typer.Option(help="Column of times, by name.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="Of the speeds: m/s, km/h, mph, knots [default: header's].")
    ] = None,
    time_unit: Annotated[
        str | None, typer.Option(help="Of the times: s, ms, us, ns, min [default: header's, or s].")
    ] = None,
    time: Annotated[str | None, typer.Option(help="as-given, or from-first.")] = None,
    where: Annotated[
        list[str] | None,
        typer.Option(metavar="COLUMN=VALUE", help="The only rows to read; repeatable."),
    ] = None,
    limit_mps2: Annotated[
        float, typer.Option(help="Limit of commands to compare with, m/s².")
    ] = Control().acceleration_limit_mps2,
    out: Annotated[Path | None, typer.Option(help="Folder [default: runs/<time>-trace].")] = None,
) -> None:
    """Show what a scenario's trace would read of a file: table, picture, limits."""
    from zenvoy.cli.trace import options_of, trace

    if not 0.0 < limit_mps2 < float("inf"):
        refuse(f"--limit-mps2 {limit_mps2:g}: is not a number above 0")
    options = options_of(column, time_column, unit, time_unit, time, where or [])
    raise typer.Exit(trace(file, options, limit_mps2, out, console, errors))


for command in COMMANDS:
    app.command()(command)


@app.command()
def reproduce(
    seeds: Annotated[
        int, typer.Option(min=2, max=10_000, help="Seeds of each case, from 1 on.")
    ] = 30,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1_000, help="Runs at a time [default: one per core].")
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
    from zenvoy.cli.reproduce import reproduce

    with _studying(duration_s, out, runs) as at_a_time:
        reproduce(seeds, jobs or at_a_time, engine_of(bus), out, runs, duration_s, console)


@app.command()
def degradation(
    seeds: Annotated[
        int, typer.Option(min=1, max=10_000, help="Seeds of each point, from 1 on.")
    ] = 3,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1_000, help="Runs at a time [default: one per core].")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("docs/degradation"),
    runs: Annotated[
        Path, typer.Option(help="Folder of what is kept of each run; it is not run again.")
    ] = Path("runs/degradation"),
    duration_s: DurationOption = None,
) -> None:
    """Run bilateral control over worse and worse channels; leaves a table and a figure."""
    from zenvoy.cli.degradation import degradation

    with _studying(duration_s, out, runs) as at_a_time:
        degradation(seeds, jobs or at_a_time, out, runs, duration_s, console)


@contextmanager
def _studying(duration_s: float | None, out: Path, runs: Path) -> Iterator[int]:
    """Runs at a time; ends politely when a study cannot begin or go on, or is told to stop."""
    from zenvoy.cli.study import StudyError

    _load("paper/base", None, None, duration_s)
    for option, folder in (("--out", out), ("--runs", runs)):  # not after an hour of runs
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            refuse(f"{option} {folder}: {error.strerror}")

    try:
        with interruptible():
            yield len(os.sched_getaffinity(0))
    except (StudyError, OSError) as error:
        errors.print(f"the study cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error


def _load(
    scenario: str,
    overrides: list[str] | None,
    seed: int | None,
    duration_s: float | None,
    *,
    clock: str | None = None,
    speed: float | None = None,
) -> Loaded:
    try:
        return load(
            scenario, overrides or (), seed=seed, duration_s=duration_s, clock=clock, speed=speed
        )
    except ScenarioError as error:
        refuse(str(error))


def _tell_notes(loaded: Loaded, strict: bool) -> None:
    """What is allowed, and hardly meant; --strict refuses it."""
    if strict and loaded.notes:
        refuse("\n".join(map(str, loaded.notes)))
    for note in loaded.notes:
        errors.print(f"note: {note}")
