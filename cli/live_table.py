"""The live table of a run on a terminal, drawn by a process beside the run from its log."""

from __future__ import annotations

import io
import os
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from zenvoy.analysis.view.figures import BLOCKS, PLAIN, Figures, figures_of, sparkline
from zenvoy.analysis.view.watched import WatchedRun
from zenvoy.bus.clock import pause, wall_ns
from zenvoy.cli.beside import Beside
from zenvoy.cli.streams import REPLACED
from zenvoy.cli.terminal import visible
from zenvoy.fleet.folder import LOG
from zenvoy.fleet.progress import Progress
from zenvoy.fleet.requests import requests_held

_NAME: Final = "watch"
_DRAWN_EVERY_NS: Final = 250_000_000
_PAUSE_S: Final = 0.05
_EVENTS: Final = 3
_WORDS: Final = 44  # characters of a row before its sparkline


class LiveTable:
    """Has the screen of a terminal during a run; use it as a context manager.

    The process that draws reads the log, as the page of a run does. The run does not wait for it,
    and the table leaves out cycles rather than fall behind.
    """

    def __init__(self, console: Console, folder: Path) -> None:
        self._console, self._folder = console, folder
        self._beside = Beside(_NAME)

    def __enter__(self) -> Self:
        try:
            with requests_held():
                # The alternate screen: what stood on the terminal comes back after the run.
                self._console.set_alt_screen(True)
                self._console.show_cursor(False)
                self._console.file.flush()
                self._start()
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()

    def show(self, progress: Progress) -> None:
        """Do nothing: the table has the progress from the log."""

    def note(self, held_up: str) -> None:
        """Do nothing: the summary says at the end who held up the run."""

    def _start(self) -> None:
        terminal = os.dup(self._console.file.fileno())  # a child's own output goes to its log
        follow = partial(_follow, self._folder / LOG, terminal, self._console.encoding)
        try:
            self._beside.start(self._folder, follow)
        finally:
            os.close(terminal)

    def _end(self) -> None:
        with requests_held():
            self._beside.end()
            self._console.show_cursor(True)
            self._console.set_alt_screen(False)
            self._console.file.flush()


def _follow(log: Path, terminal: int, encoding: str) -> None:
    """Draw the table until this process is killed; this is the main function of the process."""
    run = WatchedRun(log)
    drawn_ns = 0
    with os.fdopen(terminal, "wb") as screen:
        while True:
            more = log.exists() and run.extend()
            if wall_ns() - drawn_ns >= _DRAWN_EVERY_NS:
                screen.write(frame(run, os.get_terminal_size(terminal), encoding))
                screen.flush()
                drawn_ns = wall_ns()
            elif not more:
                pause(_PAUSE_S)


def frame(run: WatchedRun, size: os.terminal_size, encoding: str) -> bytes:
    """Return what draws the table over what a screen of that size shows."""
    # One column stays free: after the last one, terminals differ in where the cursor is.
    width = max(1, size.columns - 1)
    made = Console(file=io.StringIO(), force_terminal=True, width=width, height=size.lines)
    with made.capture() as captured:
        if run.begun:
            made.print(table_of(run, width, _signs(encoding)))
        else:
            made.print("the run starts")
    lines = captured.get().splitlines()[: size.lines]
    body = "\x1b[K\r\n".join(lines)
    return f"\x1b[H{body}\x1b[K\x1b[J".encode(encoding, REPLACED)


def table_of(run: WatchedRun, width: int, signs: str) -> Table:
    """Return the table of a run that has begun, with sparklines as wide as there is room."""
    about, state = run.about(), run.state(0)
    figures = figures_of(run.samples(), run.decided(), about["period"])
    room = min(40, width - _WORDS)
    made = Table.grid(padding=(0, 2))
    made.title = Text(_title(about, state["last"], figures), "bold")
    made.title_justify = "left"
    made.add_column(no_wrap=True)
    made.add_column()
    made.add_column(no_wrap=True)
    for measure in figures.measures:
        value = (
            "–"
            if np.isnan(measure.now)
            else (f"{measure.now:.2f} {measure.unit}, worst {measure.worst:.2f}")
        )
        drawn = sparkline(measure.values, room, signs) if room > 0 else ""
        made.add_row(measure.name, value, drawn)
    late = ", ".join(f"{vehicle} ({age:.2f} s)" for vehicle, age in figures.late)
    made.add_row("late", Text(late or "nobody"))
    named = {mode: name for mode, (name, _) in about["modes"].items()}
    modes = ", ".join(f"{named.get(mode, mode)}: {n}" for mode, n in figures.modes.items())
    made.add_row("modes", Text(visible(modes) or "–"))
    for event in state["events"][-_EVENTS:]:
        made.add_row(f"{event['time']:.1f} s", Text(visible(event["words"])))
    return made


def _title(about: dict[str, Any], last: int, figures: Figures) -> str:
    done_s, whole_s = max(0, last) * about["period"], about["cycles"] * about["period"]
    title = f"{visible(about['scenario'])}: {done_s:.1f} of {whole_s:g} s"
    factor = figures.real_time_factor
    return title if np.isnan(factor) else f"{title}, {factor:.1f} × real time"


def _signs(encoding: str) -> str:
    try:
        BLOCKS.encode(encoding)
    except UnicodeEncodeError:
        return PLAIN
    return BLOCKS
