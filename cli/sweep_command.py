"""`zenvoy sweep`: runs a user's own study."""

from __future__ import annotations

import typer

from zenvoy.cli import exits
from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.studying import (
    DaskOption,
    JobsOption,
    ResultsOption,
    StudyArgument,
    command_of,
    studying,
)
from zenvoy.cli.terminal import errors, say


def sweep(
    study: StudyArgument,
    out: ResultsOption = None,
    jobs: JobsOption = None,
    allow_code: AllowCodeOption = False,
    dask: DaskOption = None,
) -> None:
    """Run a scenario over axes and seeds.

    Writes a table in Parquet and figures. Finished runs are kept, and not made again.
    """
    from zenvoy.studies.sweeps.sweep import run_sweep

    with studying("sweep", "runs"):
        done = run_sweep(
            study,
            out=out,
            jobs=jobs,
            on_line=say,
            command=command_of("sweep", study, out, allow_code),
            allow_code=allow_code,
            dask=dask,
        )
    for path in done.files:
        say(str(path))
    if failed := len(done.results.failed):
        errors.print(f"{failed} of {done.results.plan.runs} runs failed; see {done.readme}")
        raise typer.Exit(exits.FAILED)


SWEEP_COMMANDS = (sweep,)
