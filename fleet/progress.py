"""The progress of a run, and the pipe through which the world reports it and who has come."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

from zenvoy.bus import messages_pb2 as pb

# The two lowest bits of a message's head; the others are the length of the message.
_CLOCK: Final = 0
_ARRIVAL: Final = 1
_HELD_UP: Final = 2


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


class Arrival(NamedTuple):
    """A process that has come (or gone), and the other machine that it runs on, if it is known."""

    process: str
    host: str
    there: bool


class HeldUp(NamedTuple):
    """A sentence on the machine that holds up the run; "" if none does."""

    text: str


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
        _write(write_fd, _CLOCK, clock.SerializeToString())

    return send


def arrivals_to(write_fd: int) -> Callable[[str, str, bool], None]:
    """Return a function that sends arrivals through the same pipe; it never blocks."""

    def send(process: str, host: str, there: bool) -> None:
        _write(write_fd, _ARRIVAL, json.dumps([process, host, there]).encode())

    return send


def held_up_to(write_fd: int) -> Callable[[str], None]:
    """Return a function that sends through the same pipe who holds up the run; it never blocks."""

    def send(text: str) -> None:
        _write(write_fd, _HELD_UP, text.encode())

    return send


def _write(write_fd: int, kind: int, payload: bytes) -> None:
    """Write a message in one piece, as a pipe takes it if it has at most 4,096 bytes."""
    try:
        os.write(write_fd, (len(payload) << 2 | kind).to_bytes(4, "little") + payload)
    except (BlockingIOError, BrokenPipeError):
        return  # nobody reads the pipe; the log has the clock all the same


class ReportReader:
    """Reads what `clock_to`, `arrivals_to` and `held_up_to` send."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> Iterator[pb.Clock | Arrival | HeldUp]:
        """Take data from the pipe; yield the messages that are now complete."""
        self._buffer += data
        while len(self._buffer) >= 4:
            head = int.from_bytes(self._buffer[:4], "little")
            end = 4 + (head >> 2)
            if len(self._buffer) < end:
                return
            message, self._buffer = self._buffer[4:end], self._buffer[end:]
            if head & 3 == _CLOCK:
                yield pb.Clock.FromString(message)
            elif head & 3 == _HELD_UP:
                yield HeldUp(message.decode())
            else:
                yield Arrival(*json.loads(message))
