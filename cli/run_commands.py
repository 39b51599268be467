"""The commands that run a scenario, or join a run.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.options import (
    AllowCodeOption,
    Bus,
    CertsOption,
    DurationOption,
    EngineName,
    FoxgloveOption,
    InsecureOption,
    PerProcessOption,
    RealtimeOption,
    RouterOption,
    ScenarioArgument,
    SeedOption,
    SetOption,
    SpeedOption,
    StrictOption,
    ViewOption,
    choice_of,
    print_notes,
    scenario_of,
    the_endpoints,
    the_per_process,
)
from zenvoy.cli.streams import flush
from zenvoy.cli.terminal import console, errors, has_screen, refuse, say
from zenvoy.fleet.per_process import crowd
from zenvoy.fleet.requests import interruptible


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
    realtime: RealtimeOption = False,
    speed: SpeedOption = None,
    vehicles_per_process: PerProcessOption = "1",
    without: Annotated[
        list[int] | None,
        typer.Option(metavar="ID", help="Leave this vehicle to another program; repeatable."),
    ] = None,
    listen: Annotated[
        list[str] | None,
        typer.Option(
            metavar="tls/HOST:PORT",
            help="Let the world listen here too, and the channel on the next port; repeatable. "
            "tcp/HOST:PORT has no locks.",
        ),
    ] = None,
    router: RouterOption = None,
    certs: CertsOption = None,
    insecure: InsecureOption = False,
    view: ViewOption = False,
    foxglove: FoxgloveOption = False,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show a live table on the terminal during the run.")
    ] = False,
    strict: StrictOption = False,
    allow_code: AllowCodeOption = False,
) -> None:
    """Run a scenario and log it to a folder.

    The folder also gets a summary and the text output of each process.
    """
    if watch and not has_screen(console):
        refuse("--watch: standard output is no terminal with a cursor; allowed: on a terminal")
    if watch and (view or foxglove):
        refuse(
            "--watch: its table would hide the address that --view or --foxglove prints; "
            "allowed: one of them"
        )
    if foxglove:
        from zenvoy.cli.foxglove_viewing import refuse_without_foxglove

        refuse_without_foxglove()
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
    per_process = the_per_process(vehicles_per_process, loaded.scenario.fleet.size)
    if (without or listen or router or per_process > 1) and asked != "processes":
        refuse(
            "--without, --listen, --router and --vehicles-per-process need processes; "
            "allowed: --engine processes"
        )
    from zenvoy.cli.opening import guests_of

    others = guests_of(
        without or (),
        listen or (),
        loaded.scenario,
        certs,
        insecure=insecure,
        router=router,
        per_process=per_process,
    )
    from zenvoy.fleet.choice import EngineError, choose

    try:
        chosen = choose(asked, loaded.scenario)
    except EngineError as error:
        refuse(str(error))
    print_notes(loaded, strict)
    if chosen.engine == "processes" and (text := crowd(loaded.scenario.fleet.size, per_process)):
        errors.print(f"note: {text}")
    if asked == "auto":
        say(f"engine: {chosen.engine}")
        for line in chosen.not_arrays:
            say(f"  {line}")
    from zenvoy.cli.execute import execute

    run_it = partial(execute, loaded, out, chosen.engine, console, errors, others, per_process)
    if watch:
        from zenvoy.cli.live_table import LiveTable

        run_it = partial(run_it, table=LiveTable)
    if not (view or foxglove):
        with interruptible():
            code = run_it()
        raise typer.Exit(code)
    from zenvoy.cli.shown import run_shown

    kills = per_process == 1
    code = run_shown(run_it, loaded.scenario, page=view, foxglove=foxglove, kills=kills)
    raise typer.Exit(code)


def vehicle(
    vehicle: Annotated[int, typer.Option("--id", help="Number of the vehicle, from 1 on.")],
    run: Annotated[str, typer.Option(help="Folder of the run, or its name if --connect is given.")],
    connect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT", help="Endpoint of the world; repeat it for that of the channel."
        ),
    ] = None,
    router: RouterOption = None,
    certs: CertsOption = None,
    timeout_s: Annotated[
        float, typer.Option(help="Longest wait for an answer of the run, s [0.1 to 86400].")
    ] = 10.0,
    allow_code: AllowCodeOption = False,
) -> None:
    """Join a run in place of a vehicle that is missing."""
    from zenvoy.cli.join import join

    with interruptible():
        code = join(
            vehicle,
            run,
            the_endpoints(connect, router, needed=False),
            timeout_s,
            console,
            errors,
            certs,
            router=router is not None,
            allow_code=allow_code,
        )
    os._exit(flush(code))  # an open session would keep the interpreter from exiting


RUN_COMMANDS = (run, vehicle)
