"""`zenvoy run`, from the loaded scenario to the exit code."""

from __future__ import annotations

import socket
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING

from rich.console import Console

from zenvoy.analysis.log.arrays import LogError, as_json
from zenvoy.analysis.measures.spacing import spacing_of
from zenvoy.analysis.measures.summary import summarize
from zenvoy.bus.text import utf8
from zenvoy.cli import exits
from zenvoy.cli.progress import RunProgress
from zenvoy.cli.report import print_summary
from zenvoy.cli.waiting import Waiting
from zenvoy.fleet.ends import Death, shortage_of
from zenvoy.fleet.engine import Engine
from zenvoy.fleet.folder import LOG, SUMMARY, FolderError, make_folder
from zenvoy.fleet.guests import NO_GUESTS, Guests
from zenvoy.fleet.interruption import Interrupted
from zenvoy.fleet.run import Watch, run
from zenvoy.scenarios import Loaded, Scenario

if TYPE_CHECKING:
    from zenvoy.cli.live_table import LiveTable


def execute(
    loaded: Loaded,
    out: Path | None,
    engine: Engine,
    console: Console,
    errors: Console,
    guests: Guests = NO_GUESTS,
    per_process: int = 1,
    waiting: Waiting | None = None,
    on_folder: Callable[[Path], None] = lambda _: None,
    by_hand: socket.socket | None = None,
    table: Callable[[Console, Path], LiveTable] | None = None,
) -> int:
    """Run a scenario, and print its summary and its folder; return the exit code.

    `on_folder` gets the folder before the run begins; `by_hand` is for `fleet.run`.
    `table` makes what the terminal shows in place of the bar, from the folder.
    """
    try:
        folder = make_folder(out, loaded.name)
    except FolderError as error:
        errors.print(f"--out {error}")
        return exits.BAD_INPUT
    on_folder(folder)
    for vehicle in sorted(guests.without):
        join = f"zenvoy vehicle --id {vehicle} --run {quote(str(folder))}"
        console.print(
            f"without vehicle {vehicle}; to join it: {join}", highlight=False, soft_wrap=True
        )
    death: Death | None = None
    code = exits.OK
    tell_loss = partial(_print_death, errors=errors, then="; the run goes on")
    held: list[Death] = []  # until the table gives the screen back
    bad_ends: list[Death] = []
    bar = RunProgress(console, loaded.name, loaded.scenario.duration_s)
    shown = bar if table is None else table(console, folder)
    try:
        with shown as progress:
            on_loss = tell_loss if table is None else held.append
            watch = Watch(
                on_progress=progress.show,
                on_loss=on_loss,
                on_held_up=progress.note,
                on_bad_end=bad_ends.append,
            )
            if waiting is not None:
                watch = replace(
                    watch,
                    on_endpoints=waiting.begin,
                    on_arrival=waiting.note,
                    on_idle=waiting.tell,
                )
            death = run(
                loaded,
                folder,
                engine,
                watch,
                guests=guests,
                per_process=per_process,
                by_hand=by_hand,
            )
    except Interrupted as interrupted:
        errors.print(str(interrupted))
        code = exits.INTERRUPTED
    except OSError as error:  # a full disk, too few processes or file descriptors
        errors.print(f"the run cannot go on: {shortage_of(error)}")
        code = exits.FAILED
    for lost in held:
        tell_loss(lost)
    if death is not None:
        code = _code_of(death)
        where = "" if waiting is None else waiting.where(death)
        done = "" if code else "; it had done its work: the run is complete"
        _print_death(death, errors, f"{where}{done}")
    for bad_end in bad_ends:
        _print_death(bad_end, errors)
    if (folder / LOG).exists() and not _summarize(folder, loaded.scenario, console, errors):
        code = code or exits.FAILED
    console.print(f"written to {folder}", highlight=False, soft_wrap=True)
    return code


def _code_of(death: Death) -> int:
    if death.complete:
        return exits.OK
    return exits.FAILED if death.refused else exits.PROCESS_LOST


def _print_death(death: Death, errors: Console, then: str = "") -> None:
    errors.print(f"{death}{then}")
    for line in death.tail:
        errors.print(f"  {line}")


def _summarize(folder: Path, scenario: Scenario, console: Console, errors: Console) -> bool:
    """Write the summary of the run and print it; return whether that succeeded."""
    try:
        summary = summarize(folder / LOG)
    except LogError as error:
        errors.print(f"no summary: {error}")
        return False
    if summary["end"] is None or not summary["holds"]:  # the log is damaged too
        for note in summary["notes"]:
            errors.print(note)
    try:
        (folder / SUMMARY).write_bytes(utf8(as_json(summary)))
    except OSError as error:
        errors.print(f"no summary: {shortage_of(error)}")
        return False
    if summary["cycles"]:
        print_summary(console, summary, spacing_of(scenario))
    return True
