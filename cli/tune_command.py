"""`zenvoy tune`: searches for the best values of settings."""

from __future__ import annotations

from typing import Annotated

import typer

from zenvoy.cli import exits
from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.studying import ResultsOption, StudyArgument, command_of, studying
from zenvoy.cli.terminal import errors, say


def tune(
    study: StudyArgument,
    out: ResultsOption = None,
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

    with studying("search", "trials"):
        done = run_tune(
            study,
            out=out,
            jobs=jobs,
            on_line=say,
            command=command_of("tune", study, out, allow_code),
            allow_code=allow_code,
        )
    for path in done.files:
        say(str(path))
    if done.best is None:
        errors.print(f"no trial is feasible; see {done.readme}")
        raise typer.Exit(exits.FAILED)
    say(f"best: trial {done.best.number}: {done.best.settings}: {done.best.told(done.study)}")
    if done.failed:
        errors.print(f"{done.failed} of {len(done.trials)} trials failed; see {done.readme}")
        raise typer.Exit(exits.FAILED)


TUNE_COMMANDS = (tune,)
