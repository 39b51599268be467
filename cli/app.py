"""The `zenvoy` command.

Each command imports its own dependencies, so that `zenvoy show` does not wait for the imports of
`zenvoy run`. filterpy alone takes more than a second.
"""

from __future__ import annotations

import os
import sys
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from zenvoy.cli.calibrate_command import calibrate
from zenvoy.cli.compare_laws_command import COMPARE_LAWS_COMMANDS
from zenvoy.cli.convoys_command import convoys
from zenvoy.cli.import_commands import IMPORT
from zenvoy.cli.log_commands import LOG_COMMANDS
from zenvoy.cli.mixed_command import MIXED_COMMANDS
from zenvoy.cli.new import NEW
from zenvoy.cli.options import (
    AllowCodeOption,
    Bus,
    DurationOption,
    EngineName,
    ScenarioArgument,
    SeedOption,
    SetOption,
    StrictOption,
    choice_of,
    scenario_of,
)
from zenvoy.cli.streams import flush
from zenvoy.cli.study_commands import STUDY_COMMANDS
from zenvoy.cli.sweep_command import SWEEP_COMMANDS
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.cli.tune_command import TUNE_COMMANDS
from zenvoy.cli.usage import App
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import (
    Control,
    Loaded,
    ScenarioError,
    builtin,
    effective_yaml,
)
from zenvoy.scenarios import technologies as builtin_technologies
from zenvoy.scenarios.reading.technology_files import technology_in

app = App(
    name="zenvoy",
    help="Emulate convoys of vehicles that talk to each other (V2V).",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


app.add_typer(IMPORT, name="import")
app.add_typer(NEW, name="new")


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
    """Take the options that stand before a command."""


@app.command()
def run(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: DurationOption = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run [default: runs/<time>-<scenario>].")
    ] = None,
    engine: Annotated[
        EngineName | None,
        typer.Option(
            help="A process per vehicle on Zenoh; the whole fleet in one process; the fleet as "
            "arrays; or auto: arrays where they run the scenario, else in-process "
            "[default: processes]."
        ),
    ] = None,
    bus: Annotated[
        Bus | None,
        typer.Option(help="Older spelling of --engine; zenoh stands for processes."),
    ] = None,
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="Run on the wall clock, not as fast as possible."),
    ] = False,
    speed: Annotated[
        float | None,
        typer.Option(help="In real time: simulated time per wall time, 0.1 to 10."),
    ] = None,
    per_process: Annotated[
        int,
        typer.Option("--vehicles-per-process", help="Neighbouring vehicles that share a process."),
    ] = 1,
    without: Annotated[
        list[int] | None,
        typer.Option(metavar="ID", help="Leave this vehicle to another program; repeatable."),
    ] = None,
    listen: Annotated[
        list[str] | None,
        typer.Option(
            metavar="tcp/HOST:PORT",
            help="Let the world listen here too, and the channel on the next port; repeatable.",
        ),
    ] = None,
    strict: StrictOption = False,
    allow_code: AllowCodeOption = False,
) -> None:
    """Run a scenario and log it to a folder.

    The folder also gets a summary and the text output of each process.
    """
    asked = choice_of(engine, bus)
    clock = "realtime" if realtime else None
    loaded = scenario_of(
        scenario,
        overrides,
        seed,
        duration_s,
        clock=clock,
        speed=speed,
        allow_code=allow_code,
    )
    if loaded.scenario.clock == "realtime" and asked != "processes":
        refuse("clock: realtime needs processes; allowed: --engine processes")
    if per_process < 1:
        refuse(f"--vehicles-per-process {per_process}: is not at least 1")
    if (without or listen or per_process > 1) and asked != "processes":
        refuse(
            "--without, --listen and --vehicles-per-process need processes; "
            "allowed: --engine processes"
        )
    from zenvoy.fleet.guests import GuestsError, guests

    try:
        others = guests(without or (), listen or (), loaded.scenario.fleet.size)
    except GuestsError as error:
        refuse(str(error))
    from zenvoy.fleet.choice import EngineError, choose

    try:
        chosen = choose(asked, loaded.scenario)
    except EngineError as error:
        refuse(str(error))
    _print_notes(loaded, strict)
    if asked == "auto":
        _print_lines(f"engine: {chosen.engine}", *(f"  {line}" for line in chosen.not_arrays))
    from zenvoy.cli.execute import execute

    with interruptible():
        code = execute(loaded, out, chosen.engine, console, errors, others, per_process)
    raise typer.Exit(code)


@app.command()
def vehicle(
    vehicle: Annotated[int, typer.Option("--id", help="Number of the vehicle, from 1 on.")],
    run: Annotated[str, typer.Option(help="Folder of the run, or its name if --connect is given.")],
    connect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT", help="Endpoint of the world; repeat it for that of the channel."
        ),
    ] = None,
    timeout_s: Annotated[
        float, typer.Option(help="Longest wait for an answer of the run, s [0.1 to 86400].")
    ] = 10.0,
    allow_code: AllowCodeOption = False,
) -> None:
    """Join a run in place of a vehicle that is missing."""
    from zenvoy.cli.join import join

    with interruptible():
        code = join(vehicle, run, connect or (), timeout_s, console, errors, allow_code=allow_code)
    os._exit(flush(code))  # an open session would keep the interpreter from exiting


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
    allow_code: AllowCodeOption = False,
) -> None:
    """Print a scenario with all its defaults.

    The output is a valid scenario file.
    """
    shown = scenario_of(scenario, overrides, seed, duration_s, allow_code=allow_code).scenario
    # A scenario file is UTF-8. On a terminal of another encoding, print ASCII alone.
    utf = sys.stdout.encoding.lower().startswith("utf")
    sys.stdout.write(effective_yaml(shown, ascii_only=not utf))


@app.command()
def check(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    strict: StrictOption = False,
    allow_code: AllowCodeOption = False,
) -> None:
    """Check a scenario and print all its errors.

    Also says whether the array engine runs it.
    """
    loaded = scenario_of(scenario, overrides, None, None, allow_code=allow_code)
    _print_notes(loaded, strict)
    size, duration_s = loaded.scenario.fleet.size, loaded.scenario.duration_s
    console.print(f"{loaded.name}: valid; {size} vehicles, {duration_s:g} s", soft_wrap=True)
    from zenvoy.fleet.arrays.covered import uncovered

    _print_lines(*(uncovered(loaded.scenario) or ["runs on arrays"]))


@app.command()
def technologies(
    files: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FILE]...", help="Files of your own technologies to add."),
    ] = None,
) -> None:
    """Print the V2X technologies.

    These are the technologies of the paper's Table I, and those in the files given.
    """
    from zenvoy.cli.report import print_technologies

    try:
        own = [technology_in(file) for file in files or ()]
    except ScenarioError as error:
        refuse(str(error))
    title = "V2X technologies (paper, Table I)" if not own else "V2X technologies"
    print_technologies(console, [*builtin_technologies().values(), *own], title)


@app.command()
def channel(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: Annotated[float, typer.Option(help="Simulated time to draw, s.")] = 60.0,
    out: Annotated[Path | None, typer.Option(help="Folder [default: runs/<time>-channel].")] = None,
    allow_code: AllowCodeOption = False,
) -> None:
    """Draw what a channel does to beacons.

    Shows latency, delivery by distance, bursts of losses and age of information, without a run.
    """
    from zenvoy.cli.channel import channel

    loaded = scenario_of(scenario, overrides, seed, duration_s, allow_code=allow_code)
    raise typer.Exit(channel(loaded, out, console, errors))


@app.command()
def trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of times and speeds.")],
    column: Annotated[str | None, typer.Option(help="Name of the column of speeds.")] = None,
    time_column: Annotated[str | None, typer.Option(help="Name of the column of times.")] = None,
    unit: Annotated[
        str | None,
        typer.Option(help="Unit of the speeds: m/s, km/h, mph, knots [default: from the header]."),
    ] = None,
    time_unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of the times: s, ms, us, ns, min [default: from the header, or s]."
        ),
    ] = None,
    time: Annotated[
        str | None, typer.Option(help="as-given, or from-first: the first time is 0.")
    ] = None,
    where: Annotated[
        list[str] | None,
        typer.Option(metavar="COLUMN=VALUE", help="Read only the rows that match; repeatable."),
    ] = None,
    limit_mps2: Annotated[
        float, typer.Option(help="Acceleration limit to compare with, m/s².")
    ] = Control().acceleration_limit_mps2,
    out: Annotated[Path | None, typer.Option(help="Folder [default: runs/<time>-trace].")] = None,
) -> None:
    """Show what a trace reads from a file.

    Prints a table and draws a picture, and compares the accelerations with a limit.
    """
    from zenvoy.cli.trace import options_of, trace

    if not 0.0 < limit_mps2 < float("inf"):
        refuse(f"--limit-mps2 {limit_mps2:g}: is not a number above 0")
    options = options_of(column, time_column, unit, time_unit, time, where or [])
    raise typer.Exit(trace(file, options, limit_mps2, out, console, errors))


for command in (
    *LOG_COMMANDS,
    *STUDY_COMMANDS,
    *SWEEP_COMMANDS,
    *COMPARE_LAWS_COMMANDS,
    *MIXED_COMMANDS,
    *TUNE_COMMANDS,
    calibrate,
    convoys,
):
    app.command()(command)


def _print_lines(*lines: str) -> None:
    """Print lines that a narrow terminal does not break."""
    for line in lines:
        console.print(line, soft_wrap=True)


def _print_notes(loaded: Loaded, strict: bool) -> None:
    """Print the notes on a valid scenario; with `strict`, print them and exit."""
    if strict and loaded.notes:
        refuse("\n".join(map(str, loaded.notes)))
    for note in loaded.notes:
        errors.print(f"note: {note}")
