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

from zenvoy.cli import exits
from zenvoy.cli.options import Bus, DurationOption, EngineName, choice_of, scenario_of
from zenvoy.cli.terminal import errors, refuse, say
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.requests import interruptible

JobsOption = Annotated[
    int | None, typer.Option(min=1, max=1_000, help="Processes at a time [default: one per core].")
]
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
        with_fingerprints = " --fingerprints" if fingerprints else ""
        command = _command(
            f"zenvoy reproduce --seeds {seeds} --engine {chosen}{with_fingerprints}", duration_s
        )
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
        command = _command(f"zenvoy degradation --seeds {seeds} --engine {chosen}", duration_s)
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


def _command(text: str, duration_s: float | None) -> str:
    return text if duration_s is None else f"{text} --duration-s {duration_s:g}"


@contextmanager
def _studying(duration_s: float | None, out: Path, runs: Path) -> Iterator[int]:
    """Yield the number of cores; if the study fails or is interrupted, print why and exit."""
    from zenvoy.studies.study import StudyError

    scenario_of("paper/base", None, None, duration_s)
    for option, folder in (("--out", out), ("--runs", runs)):  # fail now, not after an hour
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            refuse(f"{option} {folder}: {error.strerror}")

    try:
        with interruptible():
            yield len(os.sched_getaffinity(0))
    except (StudyError, OSError) as error:
        errors.print(f"the study cannot go on: {error}")
        raise typer.Exit(exits.FAILED) from error


STUDY_COMMANDS = (reproduce, degradation)
