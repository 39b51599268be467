"""`zenvoy sweep`: runs a user's own study."""

from __future__ import annotations

from zenvoy.cli.options import AllowCodeOption
from zenvoy.cli.studying import (
    DaskOption,
    JobsOption,
    ResultsOption,
    StudyArgument,
    command_of,
    print_results,
    studying,
)
from zenvoy.cli.terminal import say


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
    print_results(done.files, done.results, done.readme)


SWEEP_COMMANDS = (sweep,)
