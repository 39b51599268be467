"""`zenvoy compare-laws`: laws side by side in one scenario, over seeds."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from zenvoy.cli.options import AllowCodeOption, DurationOption, ScenarioArgument, SetOption
from zenvoy.cli.studying import DaskOption, JobsOption, options_of, print_results, studying
from zenvoy.cli.terminal import console, say
from zenvoy.laws import builtin

if TYPE_CHECKING:
    from zenvoy.studies.comparison.comparing import Comparing


def _complete(text: str) -> list[str]:
    """Return the laws of the library whose names begin with `text`."""
    return [name for name in builtin() if name.startswith(text)]


def compare_laws(
    scenario: ScenarioArgument,
    law: Annotated[
        list[str],
        typer.Option(
            metavar="LAW",
            help="A law by name, of your own as module:name or file.py:name, each with parameters "
            "if you like: 'IDM:{headway_s: 1.5}'; repeatable.",
            autocompletion=_complete,
        ),
    ],
    label: Annotated[
        list[str] | None,
        typer.Option(help="Name of a law in the results, in order; one for each law or none."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, the same for all laws.")] = 30,
    measure: Annotated[
        list[str] | None,
        typer.Option(help="A measure of sweeps, such as smallest_gap_m; repeatable."),
    ] = None,
    overrides: SetOption = None,
    duration_s: DurationOption = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the results [default: runs/<name of the scenario>-laws]."),
    ] = None,
    jobs: JobsOption = None,
    allow_code: AllowCodeOption = False,
    dask: DaskOption = None,
) -> None:
    """Compare control laws in a scenario over seeds.

    Writes tables and a picture with 95 % intervals. Finished runs are kept, and not made again.
    """
    from zenvoy.cli.sections import print_section
    from zenvoy.studies.comparison.comparing import Comparing, run_comparison
    from zenvoy.studies.comparison.table import section

    asked = Comparing(
        scenario=scenario,
        laws=law,
        labels=label or (),
        seeds=seeds,
        measures=measure or (),
        settings=overrides or (),
        duration_s=duration_s,
        allow_code=allow_code,
    )
    with studying("comparison", "runs"):
        done = run_comparison(
            asked, out=out, jobs=jobs, on_line=say, command=_command(asked, out), dask=dask
        )
    print_section(console, section(done.comparison))
    say("")
    print_results(done.files, done.comparison.results, done.readme)


def _command(asked: Comparing, out: Path | None) -> str:
    """Return the command line that makes the same results."""
    options = options_of(
        ("--law", asked.laws),
        ("--label", asked.labels),
        ("--seeds", asked.seeds),
        ("--measure", asked.measures),
        ("--set", asked.settings),
        ("--duration-s", asked.duration_s),
        ("--out", out),
        ("--allow-code", asked.allow_code),
    )
    return f"zenvoy compare-laws {quote(asked.scenario)}{options}"


COMPARE_LAWS_COMMANDS = (compare_laws,)
