"""The commands that run studies.

Each command imports its own dependencies; app.py says why.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from zenvoy.cli.options import Bus, DurationOption, EngineName, choice_of, scenario_of
from zenvoy.cli.studying import JobsOption, make_folders, options_of, studying
from zenvoy.cli.terminal import say
from zenvoy.fleet.engine import Engine

EngineOption = Annotated[
    EngineName | None,
    typer.Option(
        help="What runs them; what arrays do not run goes in process, also with auto "
        "[default: arrays]."
    ),
]
BusOption = Annotated[
    Bus | None, typer.Option(help="Older spelling of --engine; zenoh stands for processes.")
]


def reproduce(
    seeds: Annotated[
        int, typer.Option(min=2, max=10_000, help="Number of seeds per case: 1, 2, and so on.")
    ] = 30,
    jobs: JobsOption = None,
    engine: EngineOption = None,
    bus: BusOption = None,
    fingerprints: Annotated[
        bool,
        typer.Option(
            "--fingerprints",
            help="Also list the fingerprint of every run, which arrays do not need for the rest.",
        ),
    ] = False,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("docs/reproduction"),
    runs: Annotated[
        Path, typer.Option(help="Folder of the finished runs; they are not run again.")
    ] = Path("runs/reproduction"),
    duration_s: DurationOption = None,
) -> None:
    """Run the paper's evaluation.

    Writes its tables and figures, and a verdict on each claim.
    """
    from zenvoy.studies.paper import reproduce
    from zenvoy.studies.study import Study

    chosen = _engine(engine, bus)
    with _studying(duration_s, out, runs) as at_a_time:
        study = Study(
            folder=runs,
            engine=chosen,
            jobs=jobs or at_a_time,
            fingerprints=fingerprints,
            on_line=say,
        )
        options = options_of(
            ("--seeds", seeds),
            ("--engine", chosen),
            ("--fingerprints", fingerprints),
            ("--duration-s", duration_s),
        )
        command = f"zenvoy reproduce{options}"
        for path in reproduce(study, seeds=seeds, duration_s=duration_s, out=out, command=command):
            say(str(path))


def degradation(
    seeds: Annotated[
        int, typer.Option(min=1, max=10_000, help="Number of seeds per point: 1, 2, and so on.")
    ] = 3,
    jobs: JobsOption = None,
    engine: EngineOption = None,
    bus: BusOption = None,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("docs/degradation"),
    runs: Annotated[
        Path, typer.Option(help="Folder of the finished runs; they are not run again.")
    ] = Path("runs/degradation"),
    duration_s: DurationOption = None,
) -> None:
    """Run bilateral control over worse channels.

    Writes a table and a figure.
    """
    from zenvoy.studies.degradation import degradation
    from zenvoy.studies.study import Study

    chosen = _engine(engine, bus)
    with _studying(duration_s, out, runs) as at_a_time:
        study = Study(folder=runs, engine=chosen, jobs=jobs or at_a_time, on_line=say)
        options = options_of(("--seeds", seeds), ("--engine", chosen), ("--duration-s", duration_s))
        command = f"zenvoy degradation{options}"
        for path in degradation(
            study, seeds=seeds, duration_s=duration_s, out=out, command=command
        ):
            say(str(path))


def _engine(engine: EngineName | None, bus: Bus | None) -> Engine:
    """Return the engine that the options ask for."""
    if engine is None and bus is None:
        return "arrays"
    chosen = choice_of(engine, bus)
    return "arrays" if chosen == "auto" else chosen


@contextmanager
def _studying(duration_s: float | None, out: Path, runs: Path) -> Iterator[int]:
    """Yield the number of cores; if the study fails or is interrupted, print why and exit."""
    scenario_of("paper/base", None, None, duration_s)
    make_folders(out=out, runs=runs)
    with studying("study", "runs"):
        yield len(os.sched_getaffinity(0))


STUDY_COMMANDS = (reproduce, degradation)
