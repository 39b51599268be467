"""The commands that spread a run over several machines.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

import os
import re
from functools import partial
from pathlib import Path
from typing import Annotated, Final

import typer

from zenvoy.cli.options import (
    AllowCodeOption,
    CertsOption,
    DurationOption,
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
    print_notes,
    scenario_of,
    the_endpoints,
    the_per_process,
)
from zenvoy.cli.streams import flush
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.fleet.requests import interruptible

_SPAN: Final = re.compile(r"([1-9][0-9]{0,6})(?:-([1-9][0-9]{0,6}))?", re.ASCII)


def serve(
    scenario: ScenarioArgument,
    listen: Annotated[
        list[str] | None,
        typer.Option(
            metavar="tls/HOST:PORT",
            help="Where the world listens, and the channel on the next port; repeatable.",
        ),
    ] = None,
    router: RouterOption = None,
    overrides: SetOption = None,
    seed: SeedOption = None,
    duration_s: DurationOption = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run [default: runs/<time>-<scenario>].")
    ] = None,
    realtime: RealtimeOption = False,
    speed: SpeedOption = None,
    vehicles_per_process: PerProcessOption = "1",
    certs: CertsOption = None,
    insecure: InsecureOption = False,
    view: ViewOption = False,
    foxglove: FoxgloveOption = False,
    strict: StrictOption = False,
    allow_code: AllowCodeOption = False,
) -> None:
    """Run the world and the channel of a scenario, whose vehicles other machines drive.

    The run begins when zenvoy join has brought all vehicles.
    """
    if foxglove:
        from zenvoy.cli.foxglove_viewing import refuse_without_foxglove

        refuse_without_foxglove()
    loaded = scenario_of(
        scenario,
        overrides,
        seed,
        duration_s,
        clock="realtime" if realtime else None,
        speed=speed,
        allow_code=allow_code,
    )
    per_process = the_per_process(vehicles_per_process, loaded.scenario.fleet.size)
    if not listen and router is None:
        refuse("--listen or --router: is missing; allowed: where to listen, or a Zenoh router")
    from zenvoy.bus.vehicle_processes import vehicle_processes
    from zenvoy.cli.execute import execute
    from zenvoy.cli.opening import guests_of
    from zenvoy.cli.waiting import Waiting
    from zenvoy.fleet.muster import Muster

    size = loaded.scenario.fleet.size
    guests = guests_of(
        (),
        listen or (),
        loaded.scenario,
        certs,
        insecure=insecure,
        router=router,
        all_elsewhere=True,
    )
    print_notes(loaded, strict)
    muster = Muster(vehicle_processes(size, per_process))
    waiting = Waiting(muster, console, certs, realtime=loaded.scenario.clock == "realtime")
    run_it = partial(
        execute, loaded, out, "processes", console, errors, guests, per_process, waiting=waiting
    )
    if not (view or foxglove):
        with interruptible():
            code = run_it()
        raise typer.Exit(code)
    from zenvoy.cli.shown import run_shown

    # The vehicles run elsewhere.
    code = run_shown(run_it, loaded.scenario, page=view, foxglove=foxglove, kills=False)
    raise typer.Exit(code)


def join(
    vehicles: Annotated[str, typer.Option(metavar="N-M", help="The vehicles to drive here.")],
    connect: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT", help="Endpoint of the world; repeat it for that of the channel."
        ),
    ] = None,
    router: RouterOption = None,
    run: Annotated[
        str | None,
        typer.Option(help="Name of the run, as zenvoy serve prints it [default: the only one]."),
    ] = None,
    per_process: Annotated[
        int | None,
        typer.Option(
            "--vehicles-per-process",
            help="Vehicles that share a process, as zenvoy serve has it [default: the same].",
        ),
    ] = None,
    certs: CertsOption = None,
    host: Annotated[
        str | None, typer.Option(help="Name of this machine in messages [default: its own].")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of text logs [default: runs/<time>-join-N-M].")
    ] = None,
    timeout_s: Annotated[
        float,
        typer.Option(help="Longest wait for an answer of the run, s.", min=0.1, max=86_400),
    ] = 10.0,
    allow_code: AllowCodeOption = False,
) -> None:
    """Drive a share of the vehicles of a run that zenvoy serve has started."""
    found = _SPAN.fullmatch(vehicles)
    if found is None or int(found[2] or found[1]) < int(found[1]):
        refuse(f"--vehicles {vehicles}: is not N or N-M with 1 <= N <= M, as 21-40")
    span = range(int(found[1]), int(found[2] or found[1]) + 1)
    endpoints = the_endpoints(connect, router, needed=True)
    from zenvoy.cli.sharing import join_share

    with interruptible():
        code = join_share(
            span,
            run,
            endpoints,
            timeout_s,
            certs,
            console,
            errors,
            out=out,
            per_process=per_process,
            host=host,
            router=router is not None,
            allow_code=allow_code,
        )
    os._exit(flush(code))


HOST_COMMANDS = (serve, join)
