"""`zenvoy trace`: show what a scenario would read from a file of speeds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from zenvoy.analysis.chapters.trace import trace_section
from zenvoy.analysis.page.html import Page
from zenvoy.analysis.page.report import made_by
from zenvoy.bus.clock import stamp
from zenvoy.cli import exits
from zenvoy.cli.analyze import OutError, folder_for, write_page
from zenvoy.cli.sections import print_section
from zenvoy.cli.terminal import refuse
from zenvoy.scenarios import TRACE_OPTIONS, Problem, ScenarioError, read_trace


def trace(
    file: Path,
    options: Mapping[str, object],
    limit_mps2: float,
    out: Path | None,
    console: Console,
    errors: Console,
) -> int:
    """Print and draw what is read from the file, next to the limit; return the exit code."""
    try:
        read = read_trace(file, options)
        folder = folder_for(Path("runs") / f"{stamp()}-trace" if out is None else out)
    except ScenarioError as error:
        for problem in error.problems:
            errors.print(_of_the_command(problem))
        return exits.BAD_INPUT
    except OutError as error:
        errors.print(str(error))
        return exits.BAD_INPUT
    section = trace_section(read, limit_mps2)
    event = _event(file, options)

    def print_result() -> None:
        print_section(console, section)
        console.print(f"\nIn a scenario:\n\n{event}", soft_wrap=True)

    page = Page(
        title=f"Trace {file.name}",
        lead=f"{read.column} over {read.time_column}, as a scenario would read it.",
        sections=(section,),
        folded=(("In a scenario", event),),
        made=(made_by(f"zenvoy trace {file}"),),
    )
    return write_page(page, "trace.html", folder, console, errors, print_result)


def options_of(
    column: str | None,
    time_column: str | None,
    unit: str | None,
    time_unit: str | None,
    time: str | None,
    where: Sequence[str],
) -> dict[str, object]:
    """Return the options that are given; if one cannot be read, print why and exit."""
    given = {
        "column": column,
        "time_column": time_column,
        "unit": unit,
        "time_unit": time_unit,
        "time": time,
    }
    options: dict[str, object] = {key: value for key, value in given.items() if value is not None}
    pairs = {}
    for pair in where:
        name, equals, value = pair.partition("=")
        if not equals or not name or name in pairs:
            refuse(f"--where {pair}: is not of the form COLUMN=VALUE, each column once")
        pairs[name.strip()] = value.strip()
    return {**options, "where": pairs} if pairs else options


def _of_the_command(problem: Problem) -> str:
    """Return the problem as text that names an option as the command line does."""
    key = "--" + problem.key.replace("_", "-") if problem.key in TRACE_OPTIONS else ""
    return str(replace(problem, key=key))


def _event(file: Path, options: Mapping[str, object]) -> str:
    """Return the event that reads the file with these options, as YAML, of which JSON is a part."""
    values = {"type": "trace", "vehicle": 1, "at_s": 0, "file": str(file), **options}
    lines = (f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
    return "events:\n  - " + "\n    ".join(lines) + "\n"
