"""What the commands that run studies share: options, folders, the results, and how they end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, refuse, say
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import ScenarioError

if TYPE_CHECKING:
    from zenvoy.studies.sweeps.results import Results

StudyArgument = Annotated[str, typer.Argument(metavar="STUDY", help="A study, a YAML file.")]
ResultsOption = Annotated[
    Path | None, typer.Option(help="Folder of the results [default: runs/<name of the study>].")
]


JobsOption = Annotated[
    int | None, typer.Option(min=1, max=1_000, help="Processes at a time [default: one per core].")
]
DaskOption = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Have the workers of a Dask cluster make the runs; the address of its scheduler.",
    ),
]


def options_of(*given: tuple[str, object]) -> str:
    """Return options and their values as on a command line; None and empty lists are left out."""
    written = []
    for name, value in given:
        if isinstance(value, bool):
            written += [name] if value else []
        elif value is not None:
            values = value if isinstance(value, list | tuple) else (value,)
            written += [f"{name} {quote(str(one))}" for one in values]
    return "".join(f" {one}" for one in written)


def command_of(name: str, study: str, out: Path | None, allow_code: bool) -> str:
    """Return the command line that makes the same results."""
    options = options_of(("--out", out), ("--allow-code", allow_code))
    return f"zenvoy {name} {quote(study)}{options}"


def make_folders(**folders: Path) -> None:
    """Make the folders that options name; if one cannot be made, print why and exit.

    Call it before the runs, so that nobody waits an hour for this.
    """
    for option, folder in folders.items():
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            refuse(f"--{option} {folder}: {error.strerror}")


def print_results(files: Sequence[Path], results: Results, readme: Path) -> None:
    """Print the files of a sweep; if runs failed, say where that is explained, and exit."""
    for path in files:
        say(str(path))
    if failed := len(results.failed):
        errors.print(f"{failed} of {results.plan.runs} runs failed; see {readme}")
        raise typer.Exit(exits.FAILED)


@contextmanager
def studying(what: str, parts: str) -> Iterator[None]:
    """Print why a study is refused, cannot go on or is interrupted, and exit.

    `what` names such a study, and `parts` names its parts that are kept.
    """
    from zenvoy.studies.study import StudyError
    from zenvoy.studies.sweeps.errors import NoClusterError

    try:
        with interruptible():
            yield
    except (ScenarioError, NoClusterError) as error:
        refuse(str(error))
    except (StudyError, OSError) as error:
        errors.print(f"the {what} cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error
    except KeyboardInterrupt:
        errors.print(f"interrupted; the finished {parts} are kept")
        raise typer.Exit(exits.INTERRUPTED) from None
