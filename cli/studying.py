"""Options of the commands for a user's own study, and how these commands end early."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, refuse
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import ScenarioError

StudyArgument = Annotated[str, typer.Argument(metavar="STUDY", help="A study, a YAML file.")]
ResultsOption = Annotated[
    Path | None, typer.Option(help="Folder of the results [default: runs/<name of the study>].")
]


def command_of(name: str, study: str, out: Path | None, allow_code: bool) -> str:
    """Return the command line that makes the same results."""
    command = f"zenvoy {name} {quote(study)}" + (f" --out {quote(str(out))}" if out else "")
    return command + (" --allow-code" if allow_code else "")


@contextmanager
def studying(what: str, parts: str) -> Iterator[None]:
    """Print why a study is refused, cannot go on or is interrupted, and exit.

    `what` names such a study, and `parts` names its parts that are kept.
    """
    from zenvoy.studies.sweeps.errors import ClusterError, NoClusterError

    try:
        with interruptible():
            yield
    except (ScenarioError, NoClusterError) as error:
        refuse(str(error))
    except (ClusterError, OSError) as error:
        errors.print(f"the {what} cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error
    except KeyboardInterrupt:
        errors.print(f"interrupted; the finished {parts} are kept")
        raise typer.Exit(exits.INTERRUPTED) from None
