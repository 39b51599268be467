"""How a run in this process is interrupted, and the message about it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from zenvoy.bus import messages_pb2 as pb
from zenvoy.fleet.requests import requests_to_end_handled_by
from zenvoy.world.recorder import Recorder


class Interrupted(KeyboardInterrupt):
    """A signal has asked the command to end; `complete` says whether the run was over by then."""

    def __init__(self, *, complete: bool) -> None:
        super().__init__()
        self.complete = complete

    def __str__(self) -> str:
        kept = "the run was complete by then" if self.complete else "the log up to here is kept"
        return f"interrupted; {kept}"


@contextmanager
def interrupted_between(recorder: Recorder) -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP end the run between two messages of the log.

    The recorder's `on_clock` then raises KeyboardInterrupt.
    """
    asked = False
    show = recorder.on_clock

    def ask(_signal: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked = True

    def tick(clock: pb.Clock) -> None:
        show(clock)
        if asked:
            raise KeyboardInterrupt

    recorder.on_clock = tick
    with requests_to_end_handled_by(ask):
        yield
