"""`zenvoy mixed-traffic`: human drivers and equipped cars on a ring, over seeds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.options import DurationOption
from zenvoy.cli.studying import JobsOption, make_folders, options_of, studying
from zenvoy.cli.terminal import say


def mixed_traffic(
    seeds: Annotated[
        int, typer.Option(min=2, max=10_000, help="Number of seeds: 1, 2, and so on.")
    ] = 30,
    jobs: JobsOption = None,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("docs/mixed-traffic"),
    runs: Annotated[
        Path, typer.Option(help="Folder of the finished runs; they are not run again.")
    ] = Path("runs/mixed-traffic"),
    duration_s: DurationOption = None,
) -> None:
    """Run human drivers and equipped cars on a ring.

    Writes tables and pictures: of a wave that one controlled car ends, and of growing shares of
    equipped cars.
    """
    from zenvoy.studies.mixed.mixed import require_control, run_mixed

    command = f"zenvoy mixed-traffic{options_of(('--seeds', seeds), ('--duration-s', duration_s))}"
    with studying("study", "runs"):
        require_control(duration_s)
        make_folders(out=out, runs=runs)
        files = run_mixed(
            seeds=seeds,
            duration_s=duration_s,
            out=out,
            runs=runs,
            jobs=jobs,
            on_line=say,
            command=command,
        )
    for path in files:
        say(str(path))


MIXED_COMMANDS = (mixed_traffic,)
