"""`zenvoy sweep`: runs a study of the user's own."""

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


def sweep(
    study: Annotated[str, typer.Argument(metavar="STUDY", help="A study, a YAML file.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results [default: runs/<name of the study>].")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, max=1_000, help="Runs at a time [default: one per core].")
    ] = None,
    allow_code: AllowCodeOption = False,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Have the workers of a Dask cluster make the runs; the address of its scheduler.",
        ),
    ] = None,
) -> None:
    """Run a scenario over axes and seeds.

    Writes a table in Parquet and figures. Finished runs are kept, and not made again.
    """
    from zenvoy.studies.sweeps.errors import ClusterError, NoClusterError
    from zenvoy.studies.sweeps.sweep import run_sweep

    command = f"zenvoy sweep {quote(study)}" + (f" --out {quote(str(out))}" if out else "")
    command += " --allow-code" if allow_code else ""
    try:
        with interruptible():
            done = run_sweep(
                study,
                out=out,
                jobs=jobs,
                on_line=_print,
                command=command,
                allow_code=allow_code,
                dask=dask,
            )
    except (ScenarioError, NoClusterError) as error:
        refuse(str(error))
    except (ClusterError, OSError) as error:
        errors.print(f"the sweep cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error
    except KeyboardInterrupt:
        errors.print("interrupted; the finished runs are kept")
        raise typer.Exit(exits.INTERRUPTED) from None
    for path in done.files:
        _print(str(path))
    if failed := len(done.results.failed):
        errors.print(f"{failed} of {done.results.plan.runs} runs failed; see {done.readme}")
        raise typer.Exit(exits.FAILED)


def _print(text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


SWEEP_COMMANDS = (sweep,)
