"""The commands that show what a technology, a channel or a trace gives to a run, without a run.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.options import (
    AllowCodeOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
    scenario_of,
)
from zenvoy.cli.table_options import SpeedUnitOption, TimeUnitOption
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.scenarios import Control, ScenarioError
from zenvoy.scenarios import technologies as builtin_technologies
from zenvoy.scenarios.reading.technology_files import technology_in


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


def trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Table of times and speeds.")],
    column: Annotated[str | None, typer.Option(help="Name of the column of speeds.")] = None,
    time_column: Annotated[str | None, typer.Option(help="Name of the column of times.")] = None,
    unit: SpeedUnitOption = None,
    time_unit: TimeUnitOption = None,
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


PREVIEW_COMMANDS = (technologies, channel, trace)
