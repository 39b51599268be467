"""Shows how far a run is: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from zenvoy.bus import messages_pb2 as pb
from zenvoy.cli.terminal import visible

_LINE_EVERY_NS: Final = 5_000_000_000


class RunProgress:
    """Told of clock messages, now and then; use as a context."""

    def __init__(self, console: Console, name: str, duration_s: float) -> None:
        self._console = console
        self._duration_s = duration_s
        self._said_ns = 0
        self._buffer = b""
        self._bar = Progress(
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

    def feed(self, data: bytes) -> None:
        """Take clock messages as they come down a pipe, each behind its length."""
        self._buffer += data
        while len(self._buffer) >= 4:
            size = int.from_bytes(self._buffer[:4], "little")
            if len(self._buffer) < 4 + size:
                return
            clock = pb.Clock.FromString(self._buffer[4 : 4 + size])
            self._buffer = self._buffer[4 + size :]
            self.show(clock)

    def show(self, clock: pb.Clock) -> None:
        """Show one clock message."""
        simulated_s, factor = clock.time_ns * 1e-9, clock.real_time_factor
        left_s = (self._duration_s - simulated_s) / factor if factor > 0.0 else 0.0
        pace = f"{factor:.1f} × real time, {left_s:.0f} s left"
        if self._console.is_terminal:
            self._bar.update(self._task, completed=simulated_s, pace=pace)
        elif clock.wall_ns - self._said_ns >= _LINE_EVERY_NS:
            self._said_ns = clock.wall_ns
            self._console.print(f"{simulated_s:.1f} of {self._duration_s:g} s, {pace}")
