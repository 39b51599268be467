"""Shows the progress of a run: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

from zenvoy.cli.terminal import visible
from zenvoy.fleet.progress import Progress

_LINE_EVERY_S: Final = 5.0


class RunProgress:
    """Shows the progress of a run; use it as a context manager."""

    def __init__(self, console: Console, name: str, duration_s: float) -> None:
        self._console = console
        self._printed_s = 0.0
        self._held_up = ""
        self._bar = Bar(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TextColumn("{task.completed:.1f} of {task.total:g} s"),
            TextColumn("{task.fields[pace]}"),
            console=console,
            disable=not console.is_terminal,
            transient=True,
        )
        self._task = self._bar.add_task(visible(name), total=duration_s, pace="starting")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def note(self, held_up: str) -> None:
        """Take note of the machine that holds up the run, if any; lines from now on say so."""
        self._held_up = f"; {held_up}" if held_up else ""

    def show(self, progress: Progress) -> None:
        """Show the progress; away from a terminal, print a line every few seconds."""
        pace = f"{progress.real_time_factor:.1f} × real time, {progress.left_s:.0f} s left"
        pace += self._held_up
        if self._console.is_terminal:
            self._bar.update(self._task, completed=progress.time_s, pace=pace)
        elif progress.wall_s - self._printed_s >= _LINE_EVERY_S:
            self._printed_s = progress.wall_s
            text = f"{progress.time_s:.1f} of {progress.duration_s:g} s, {pace}"
            self._console.print(text)
