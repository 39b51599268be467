"""`zenvoy convoys`: compares laws with recorded convoys."""

from __future__ import annotations

import os
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.convoy_options import SkipOption, convoys_refused
from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.terminal import errors, refuse, say
from zenvoy.fleet.requests import interruptible


def convoys(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Files of OpenACC, or folders of imports."),
    ],
    law: Annotated[
        list[str] | None,
        typer.Option(help="Law to drive behind the leaders; repeatable [default: all built-in]."),
    ] = None,
    seeds: Annotated[
        int, typer.Option(min=1, max=1_000, help="Draws of who is equipped, for each share.")
    ] = 10,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1_000, help="Processes [default: one per core].")
    ] = None,
    skip_negative_gaps: SkipOption = False,
    allow_code: AllowCodeOption = False,
    out: Annotated[
        Path, typer.Option(help="Page without .md, and folder of its pictures and tables.")
    ] = Path("docs/real-convoys"),
) -> None:
    """Compare the laws with recorded convoys.

    Writes how the swing of speed grows in the recordings, behind their leaders under each law, and
    with a share of equipped cars; and which law fits the cars of today.
    """
    from zenvoy.laws import builtin
    from zenvoy.scenarios.convoys.cutting import Choice
    from zenvoy.scenarios.convoys.reading import read_convoy
    from zenvoy.studies.convoys.calibration import law_named
    from zenvoy.studies.convoys.comparison import compare
    from zenvoy.studies.convoys.page import write_page

    with convoys_refused():
        models = [law_named(name, allow_code=allow_code) for name in law or builtin()]
        choice = Choice(skip_negative_gaps=skip_negative_gaps)
        found = [read_convoy(file, choice) for file in files]
    names = [convoy.name for convoy in found]
    for name in names:
        if names.count(name) > 1:
            refuse(f"{name}: {names.count(name)} recordings have this name; allowed: one")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with interruptible():
            cores = jobs or len(os.sched_getaffinity(0))
            compared = compare(found, models, seeds=seeds, jobs=cores, say=say)
            options = "".join(f" --law {quote(name)}" for name in law or ())
            options += " --skip-negative-gaps" if skip_negative_gaps else ""
            for path in write_page(compared, out, _command(files, seeds, options, out)):
                say(str(path))
    except OSError as error:
        refuse(f"--out {out}: {error.strerror}")
    except KeyboardInterrupt:
        errors.print("interrupted; nothing is written")
        raise typer.Exit(exits.INTERRUPTED) from None


def _command(files: list[Path], seeds: int, options: str, out: Path) -> str:
    """Return the command that makes the same page, with the files by their names alone."""
    names = " ".join(quote(file.name) for file in files)
    return f"zenvoy convoys {names} --seeds {seeds}{options} --out {quote(str(out))}"
