"""Options that several commands take, and the scenario that they name."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from zenvoy.cli.terminal import refuse
from zenvoy.fleet.engine import Engine
from zenvoy.scenarios import Loaded, ScenarioError, load
from zenvoy.scenarios.reading.library import packaged


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


AllowCodeOption = Annotated[
    bool,
    typer.Option(
        "--allow-code", help="Run laws that are neither beside the scenario nor installed."
    ),
]


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
