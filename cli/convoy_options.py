"""Options of the commands that read recorded convoys, and how they report bad input."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.terminal import refuse
from zenvoy.scenarios import ScenarioError
from zenvoy.scenarios.convoys.cutting import Choice

CarsOption = Annotated[
    str | None,
    typer.Option(
        metavar="NAME,NAME…",
        help="Names or numbers of successive cars, front to back [default: the longest chain].",
    ),
]
FromOption = Annotated[
    float | None, typer.Option(help="First time to read, as in the file, s.", metavar="S")
]
ToOption = Annotated[
    float | None, typer.Option(help="Last time to read, as in the file, s.", metavar="S")
]
SkipOption = Annotated[
    bool,
    typer.Option(
        "--skip-negative-gaps",
        help="Take gaps below 0, as GNSS may show at standstill, as missing.",
    ),
]


def choice_of_cars(
    cars: str | None, from_s: float | None, to_s: float | None, skip: bool, length_m: float = 5.0
) -> Choice:
    """Return the part of a recording that the options choose."""
    named = None if cars is None else tuple(name.strip() for name in cars.split(","))
    return Choice(cars=named, from_s=from_s, to_s=to_s, length_m=length_m, skip_negative_gaps=skip)


@contextmanager
def convoys_refused() -> Iterator[None]:
    """Print why a recording or a scenario is refused, and exit."""
    try:
        yield
    except ScenarioError as error:
        refuse(str(error))


def new_folder(folder: Path) -> Path:
    """Make a folder that is new or empty; if it cannot be, print why and exit."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            refuse(f"--out {folder}: is not empty; name a new folder or an empty one")
    except OSError as error:
        refuse(f"--out {folder}: {error.strerror}")
    return folder
