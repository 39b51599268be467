"""Options that several commands share, the scenario that they load, and its notes."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.terminal import errors, refuse
from zenvoy.fleet.engine import Choice, Engine
from zenvoy.fleet.per_process import PerProcessError, per_process_of
from zenvoy.scenarios import Loaded, ScenarioError, load
from zenvoy.scenarios.reading.library import packaged


class Bus(StrEnum):
    """The engines by their older names."""

    ZENOH = "zenoh"
    IN_PROCESS = "in-process"


class EngineName(StrEnum):
    """The engines, and `auto`, as in `fleet.engine.Choice`."""

    PROCESSES = "processes"
    IN_PROCESS = "in-process"
    ARRAYS = "arrays"
    AUTO = "auto"


def engine_of(bus: Bus) -> Engine:
    """Return the engine of that older name."""
    return "processes" if bus is Bus.ZENOH else "in-process"


def choice_of(engine: EngineName | None, bus: Bus | None) -> Choice:
    """Return the engine that two options ask for; if they disagree, print an error and exit."""
    if bus is None:
        return "processes" if engine is None else engine.value
    if engine is not None and engine.value != engine_of(bus):
        refuse(f"--bus {bus.value}: contradicts --engine {engine.value}; allowed: one of them")
    return engine_of(bus)


def _complete(text: str) -> list[str]:
    """Return the built-in scenarios that begin with `text`; if there are none, files complete."""
    return [name for name in packaged() if name.startswith(text)]


ScenarioArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A built-in scenario, or a file.",
        autocompletion=_complete,
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Replace a value, e.g. channel.loss.p=0.3."),
]
SeedOption = Annotated[int | None, typer.Option(help="Replace the scenario's seed.")]
DurationOption = Annotated[float | None, typer.Option(help="Replace the duration, s.")]
StrictOption = Annotated[
    bool, typer.Option("--strict", help="Treat notes on the scenario as errors.")
]


RealtimeOption = Annotated[
    bool, typer.Option("--realtime", help="Run on the wall clock, not as fast as possible.")
]
SpeedOption = Annotated[
    float | None, typer.Option(help="In real time: simulated time per wall time, 0.1 to 10.")
]


AllowCodeOption = Annotated[
    bool,
    typer.Option(
        "--allow-code", help="Also run laws that are neither beside the scenario nor installed."
    ),
]


CertsOption = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder of certificates for TLS; zenvoy certs makes it."),
]


InsecureOption = Annotated[
    bool,
    typer.Option(
        "--insecure",
        help="Listen beyond this machine, or use a router there, without TLS, open to anybody.",
    ),
]


RouterOption = Annotated[
    str | None,
    typer.Option(
        metavar="tls/HOST:PORT", help="A Zenoh router for all processes; then nobody listens."
    ),
]


ViewOption = Annotated[
    bool, typer.Option("--view", help="Show the run in the browser, and stay until Ctrl-C.")
]


FoxgloveOption = Annotated[
    bool,
    typer.Option(
        "--foxglove", help="Serve the run to Foxglove and Lichtblick, and stay until Ctrl-C."
    ),
]


PerProcessOption = Annotated[
    str,
    typer.Option(
        "--vehicles-per-process",
        metavar="N",
        help="Neighbouring vehicles that share a process; auto: a process for each processor.",
    ),
]


def the_per_process(asked: str, size: int) -> int:
    """Return how many vehicles of a fleet of `size` share a process; for bad input, exit."""
    try:
        return per_process_of(asked, size)
    except PerProcessError as error:
        refuse(f"--vehicles-per-process {error}")


def the_endpoints(
    connect: list[str] | None, router: str | None, *, needed: bool
) -> tuple[str, ...]:
    """Return the endpoints of a run, or that of its router; if both are named, exit.

    Exit as well if they are `needed`, and there are none.
    """
    if connect and router is not None:
        refuse(f"--connect {connect[0]}: with --router everybody connects to it; allowed: one")
    if needed and not connect and router is None:
        refuse("--connect or --router: is missing; allowed: the endpoints of a run, or its router")
    return tuple(connect or ()) if router is None else (router,)


def scenario_of(
    scenario: str,
    overrides: list[str] | None,
    seed: int | None,
    duration_s: float | None,
    *,
    clock: str | None = None,
    speed: float | None = None,
    allow_code: bool = False,
) -> Loaded:
    """Return the scenario with the options applied; if it is not valid, print why and exit."""
    try:
        return load(
            scenario,
            overrides or (),
            seed=seed,
            duration_s=duration_s,
            clock=clock,
            speed=speed,
            allow_code=allow_code,
        )
    except ScenarioError as error:
        refuse(str(error))


def print_notes(loaded: Loaded, strict: bool) -> None:
    """Print the notes on a valid scenario; with `strict`, print them and exit."""
    if strict and loaded.notes:
        refuse("\n".join(map(str, loaded.notes)))
    for note in loaded.notes:
        errors.print(f"note: {note}")
