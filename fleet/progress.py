"""The progress of a run, and the pipe through which the world reports it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from zenvoy.bus import messages_pb2 as pb


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a run has come."""

    time_s: float
    """Simulated time so far, s."""
    duration_s: float
    """Simulated time of the whole run, s."""
    wall_s: float
    """Wall time since the start, s."""
    real_time_factor: float
    """Simulated time per wall time; 0 at the start."""

    @property
    def left_s(self) -> float:
        """Wall time left at this pace, s; 0 while the pace is unknown."""
        left_s = self.duration_s - self.time_s
        return left_s / self.real_time_factor if self.real_time_factor > 0.0 else 0.0


OnProgress = Callable[[Progress], None]
"""Called with the progress of a run several times a second, in the thread that runs it."""


def progress_of(clock: pb.Clock, duration_s: float) -> Progress:
    """Return the progress of a run of this duration from a clock message."""
    return Progress(
        time_s=clock.time_ns * 1e-9,
        duration_s=duration_s,
        wall_s=clock.wall_ns * 1e-9,
        real_time_factor=clock.real_time_factor,
    )


def clock_to(write_fd: int, wall_step_ns: int = 100_000_000) -> Callable[[pb.Clock], None]:
    """Return a function that sends clock messages through a pipe, at most one per `wall_step_ns`.

    It never blocks.
    """
    os.set_blocking(write_fd, False)
    last_ns = -wall_step_ns

    def send(clock: pb.Clock) -> None:
        nonlocal last_ns
        if clock.wall_ns - last_ns < wall_step_ns:
            return
        last_ns = clock.wall_ns
        payload = clock.SerializeToString()
        try:
            os.write(write_fd, len(payload).to_bytes(4, "little") + payload)
        except (BlockingIOError, BrokenPipeError):
            return  # nobody reads the pipe; the log has the message all the same

    return send


class ClockReader:
    """Reads what `clock_to` sends."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> Iterator[pb.Clock]:
        """Take data from the pipe; yield the messages that are now complete."""
        self._buffer += data
        while len(self._buffer) >= 4:
            end = 4 + int.from_bytes(self._buffer[:4], "little")
            if len(self._buffer) < end:
                return
            message, self._buffer = self._buffer[4:end], self._buffer[end:]
            yield pb.Clock.FromString(message)
