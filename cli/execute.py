"""`zenvoy run` from a loaded scenario to an exit code."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from shlex import quote

from rich.console import Console

from zenvoy.analysis.log.arrays import LogError, as_json
from zenvoy.analysis.log.cells import utf8
from zenvoy.analysis.measures.summary import summarize
from zenvoy.cli.ends import Death, want_of
from zenvoy.cli.guests import NO_GUESTS, Guests
from zenvoy.cli.progress import RunProgress
from zenvoy.cli.report import print_summary
from zenvoy.cli.run import FolderError, Interrupted, make_folder, run_in_process, run_on_zenoh
from zenvoy.scenarios import Loaded, effective_json

_OK, _FAILED, _BAD_INPUT, _PROCESS_LOST, _INTERRUPTED = 0, 1, 2, 3, 130


def execute(
    loaded: Loaded,
    out: Path | None,
    bus: str,
    console: Console,
    errors: Console,
    guests: Guests = NO_GUESTS,
    per_process: int = 1,
) -> int:
    """Run, summarize, and say where everything is; the exit code of the command."""
    try:
        folder = make_folder(out, loaded.name)
    except FolderError as error:
        errors.print(str(error))
        return _BAD_INPUT
    for vehicle in sorted(guests.without):
        join = f"zenvoy vehicle --id {vehicle} --run {quote(str(folder))}"
        console.print(
            f"without vehicle {vehicle}; to join: {join}", highlight=False, soft_wrap=True
        )
    death: Death | None = None
    code = _OK
    try:
        (folder / "effective.json").write_bytes(utf8(effective_json(loaded.scenario)))
        with RunProgress(console, loaded.name, loaded.scenario.duration_s) as progress:
            if bus == "zenoh":
                goes_on = partial(_tell_of, errors=errors, then="; the run goes on")
                death = run_on_zenoh(loaded, folder, progress, goes_on, guests, per_process)
                code = _OK if death is None else death.code
            else:
                run_in_process(loaded, folder, progress)
    except Interrupted as interrupted:
        errors.print(str(interrupted))
        code = _INTERRUPTED
    except OSError as error:  # a full disk, too few processes or file descriptors
        errors.print(f"the run cannot go on: {want_of(error)}")
        code = _FAILED
    if death is not None:
        _tell_of(death, errors, "" if code else "; its part was done, and the run is complete")
    if (folder / "run.mcap").exists() and not _summarize(folder, console, errors):
        code = code or _FAILED
    console.print(f"in {folder}", highlight=False, soft_wrap=True)
    return code


def _tell_of(death: Death, errors: Console, then: str = "") -> None:
    errors.print(f"{death}{then}")
    for line in death.tail:
        errors.print(f"  {line}")


def _summarize(folder: Path, console: Console, errors: Console) -> bool:
    """Leave the summary of the run and print it; whether that could be done."""
    try:
        summary = summarize(folder / "run.mcap")
    except LogError as error:
        errors.print(f"no summary: {error}")
        return False
    if summary["end"] is None or not summary["holds"]:  # what went wrong has hit the log too
        for note in summary["notes"]:
            errors.print(note)
    try:
        (folder / "summary.json").write_bytes(utf8(as_json(summary)))
    except OSError as error:
        errors.print(f"no summary: {want_of(error)}")
        return False
    if summary["cycles"]:
        print_summary(console, summary)
    return True
