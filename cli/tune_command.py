"""`zenvoy tune`: searches for the best values of settings."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.terminal import console, errors, refuse
from zenvoy.fleet.requests import interruptible
from zenvoy.scenarios import ScenarioError


def tune(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="A study, a YAML file.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results [default: runs/<name of the study>].")
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            min=1, max=1_000, help="Processes for the seeds of a trial [default: one per core]."
        ),
    ] = None,
    allow_code: AllowCodeOption = False,
) -> None:
    """Search for the settings that are best by a measure.

    Keeps to constraints, also of string stability in theory. Finished trials are kept.
    """
    from zenvoy.studies.tuning.tune import run_tune

    command = f"zenvoy tune {quote(study)}" + (f" --out {quote(str(out))}" if out else "")
    command += " --allow-code" if allow_code else ""
    try:
        with interruptible():
            done = run_tune(
                study,
                out=out,
                jobs=jobs,
                on_line=_print,
                command=command,
                allow_code=allow_code,
            )
    except ScenarioError as error:
        refuse(str(error))
    except OSError as error:
        errors.print(f"the search cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error
    except KeyboardInterrupt:
        errors.print("interrupted; the finished trials are kept")
        raise typer.Exit(exits.INTERRUPTED) from None
    for path in done.files:
        _print(str(path))
    if done.best is None:
        errors.print(f"no trial is feasible; see {done.readme}")
        raise typer.Exit(exits.FAILED)
    _print(f"best: trial {done.best.number}: {done.best.settings}: {done.best.told(done.study)}")
    if done.failed:
        errors.print(f"{done.failed} of {len(done.trials)} trials failed; see {done.readme}")
        raise typer.Exit(exits.FAILED)


def _print(text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


TUNE_COMMANDS = (tune,)
