"""`zenvoy calibrate`: fits a law to the cars of a recorded convoy."""

from __future__ import annotations

import math
import os
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.convoy_options import (
    CarsOption,
    FromOption,
    SkipOption,
    ToOption,
    choice_of_cars,
    convoys_refused,
    new_folder,
)
from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.terminal import console, errors, refuse, say
from zenvoy.fleet.requests import interruptible

if TYPE_CHECKING:
    from zenvoy.studies.convoys.calibration import Calibration


def calibrate(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A file of OpenACC, or the folder of an import."),
    ],
    law: Annotated[str, typer.Option(help="Law to fit: idm, acc, fm, or one of your own.")],
    hold_out: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE", help="Another recording, to try the fits on its cars; repeatable."
        ),
    ] = None,
    bound: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=LOW:HIGH", help="Range of a number; repeatable."),
    ] = None,
    cars: CarsOption = None,
    from_s: FromOption = None,
    to_s: ToOption = None,
    skip_negative_gaps: SkipOption = False,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1_000, help="Cars at a time [default: one per core].")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results [default: <name>-<law>].")
    ] = None,
    allow_code: AllowCodeOption = False,
) -> None:
    """Fit the numbers of a law to each car of a recorded convoy.

    Writes a table, a picture, and a scenario whose groups have the fitted numbers.
    """
    from zenvoy.laws.errors import LawError
    from zenvoy.scenarios.convoys.cutting import Choice
    from zenvoy.scenarios.convoys.reading import read_convoy
    from zenvoy.studies.convoys.calibration import calibrate, model_named

    bounds = dict(map(_bound, bound or ()))
    with convoys_refused():
        model = model_named(law, allow_code=allow_code)
        convoy = read_convoy(file, choice_of_cars(cars, from_s, to_s, skip_negative_gaps))
        others = Choice(skip_negative_gaps=skip_negative_gaps)
        held = [read_convoy(path, others) for path in hold_out or ()]
        folder = new_folder(Path(f"{convoy.name}-{Path(law).stem.lower()}") if out is None else out)
        say(f"{len(convoy.cars) - 1} followers, {convoy.time_s[-1]:g} s")
        try:
            with interruptible():
                found = calibrate(
                    convoy,
                    model,
                    bounds=bounds,
                    hold_out=held,
                    jobs=jobs or len(os.sched_getaffinity(0)),
                    on_fit=lambda fit: say(f"{fit.car}: {fit.rms_gap_m:.2f} m"),
                )
        except LawError as error:
            errors.print(str(error))
            raise typer.Exit(exits.FAILED) from error
        except KeyboardInterrupt:
            errors.print("interrupted")
            raise typer.Exit(exits.INTERRUPTED) from None
    raise typer.Exit(_write(found, folder, f"zenvoy calibrate {quote(str(file))} --law {law}"))


def _write(found: Calibration, folder: Path, command: str) -> int:
    """Write a calibration into a folder and print it; return the exit code."""
    from zenvoy.analysis.page.files import write_whole
    from zenvoy.analysis.page.html import Page
    from zenvoy.analysis.page.report import made_by
    from zenvoy.bus.text import utf8
    from zenvoy.cli.analyze import write_page
    from zenvoy.cli.sections import print_section
    from zenvoy.scenarios.convoys.folder import files_of
    from zenvoy.studies.convoys.calibration_page import calibration_section
    from zenvoy.studies.convoys.groups import scenario_values

    section = calibration_section(found)
    page = Page(title=section.title, sections=(section,), made=(made_by(command),))
    texts = files_of(found.convoy, scenario_values(found, folder))
    try:
        paths = write_whole(folder, {name: utf8(text) for name, text in texts.items()})
    except OSError as error:
        refuse(f"--out {folder}: {error.strerror}")
    code = write_page(
        page, "calibration.html", folder, console, errors, lambda: print_section(console, section)
    )
    for path in paths:
        say(str(path))
    return code


def _bound(text: str) -> tuple[str, tuple[float, float]]:
    """Return the name and the range in NAME=LOW:HIGH; otherwise print what is wrong and exit."""
    name, _, ends = text.partition("=")
    try:
        low, high = map(float, ends.split(":"))
    except ValueError:
        low, high = math.nan, math.nan
    if not name or not -math.inf < low < high < math.inf:
        refuse(f"--bound {text}: is not of the form NAME=LOW:HIGH, with LOW below HIGH")
    return name.strip(), (low, high)
