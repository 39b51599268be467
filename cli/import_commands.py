"""`zenvoy import`: make scenarios of recorded convoys.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from zenvoy.cli.convoy_options import (
    CarsOption,
    FromOption,
    SkipOption,
    ToOption,
    choice_of_cars,
    convoys_refused,
    new_folder,
)
from zenvoy.cli.table_options import SpeedUnitOption, TimeUnitOption
from zenvoy.cli.terminal import refuse, say
from zenvoy.cli.usage import App

if TYPE_CHECKING:
    from zenvoy.scenarios.convoys.convoy import Convoy

IMPORT = App(help="Make scenarios of recorded convoys.", no_args_is_help=True)

FileArgument = Annotated[
    Path, typer.Argument(metavar="FILE", help="Table of the cars; it may be packed, .gz.")
]
OutOption = Annotated[
    Path | None, typer.Option(help="Folder of the scenario [default: the name of the file].")
]


@IMPORT.command()
def openacc(
    file: FileArgument,
    cars: CarsOption = None,
    from_s: FromOption = None,
    to_s: ToOption = None,
    skip_negative_gaps: SkipOption = False,
    out: OutOption = None,
) -> None:
    """Make a scenario of a recording of the OpenACC database.

    The leader drives as recorded, and the other cars are kept to compare with.
    """
    from zenvoy.scenarios.convoys.reading import read_openacc

    with convoys_refused():
        convoy = read_openacc(file, choice_of_cars(cars, from_s, to_s, skip_negative_gaps))
        _write(convoy, out)


@IMPORT.command()
def table(
    file: FileArgument,
    time: Annotated[str, typer.Option(metavar="COLUMN", help="Column of times.")],
    speed: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Columns of speeds; {} is the name of a car."),
    ] = None,
    position: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN", help="Columns of positions of the fronts along the road, m."
        ),
    ] = None,
    gap: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN", help="Columns of gaps to the car ahead, bumper to bumper, m."
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Column of cars, if each has rows of its own."),
    ] = None,
    unit: SpeedUnitOption = None,
    time_unit: TimeUnitOption = None,
    length_m: Annotated[
        float, typer.Option(help="Length of the cars, by which positions become gaps.")
    ] = 5.0,
    cars: CarsOption = None,
    from_s: FromOption = None,
    to_s: ToOption = None,
    skip_negative_gaps: SkipOption = False,
    out: OutOption = None,
) -> None:
    """Make a scenario of any table of several cars.

    The table has a column for each car, such as --speed "v_{}" --gap "gap_{}", or a row for each
    car and time, with --vehicle. Positions may replace speeds, gaps or both.
    """
    from zenvoy.scenarios.convoys.columns import Columns
    from zenvoy.scenarios.convoys.reading import read_table

    if not 0.0 < length_m < 1_000.0:
        refuse(f"--length-m {length_m:g}: is not in (0, 1000)")
    with convoys_refused():
        columns = Columns(
            time=time,
            speed=speed,
            position=position,
            gap=gap,
            vehicle=vehicle,
            unit=unit,
            time_unit=time_unit,
        )
        choice = choice_of_cars(cars, from_s, to_s, skip_negative_gaps, length_m)
        _write(read_table(file, columns, choice), out)


def _write(convoy: Convoy, out: Path | None) -> None:
    """Write the scenario of a convoy into a new folder, and print what was read."""
    from zenvoy.bus.text import utf8
    from zenvoy.scenarios.convoys.folder import files_of
    from zenvoy.scenarios.convoys.scenario_of import values_of

    folder = new_folder(Path(convoy.name) if out is None else out)
    for what, value in convoy.told.items():
        say(f"{what}: {value}")
    try:
        for name, text in files_of(convoy, values_of(convoy)).items():
            (folder / name).write_bytes(utf8(text))
            say(str(folder / name))
    except OSError as error:
        refuse(f"--out {folder}: {error.strerror}")
