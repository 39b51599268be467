"""A strike waits for the moment of a case and sends the signal. Stopped processes go on later."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import zenoh

from tests.chaos.cases import CYCLES, PAUSE_S, STALL_LIMIT_S, Case
from tests.conftest import Command
from tests.let_pass import let_pass
from zenvoy.bus import messages_pb2 as pb
from zenvoy.bus.session import open_session
from zenvoy.bus.topics import CLOCK
from zenvoy.fleet.guests import read_endpoints


class TooLateError(Exception):
    """The run was complete before its processes were seen, because the machine is busy."""


class Watcher:
    """Receives the clock of a run, as any observer may."""

    def __init__(self) -> None:
        self.newest = pb.Clock()
        self.changed = threading.Condition()

    def hear(self, sample: zenoh.Sample) -> None:
        """Keep the newest clock message."""
        with self.changed:
            self.newest = pb.Clock.FromString(sample.payload.to_bytes())
            self.changed.notify_all()

    def wait_for(self, cycle: int, limit_s: float) -> bool:
        """Return whether the run reaches a cycle within the limit."""
        with self.changed:
            return self.changed.wait_for(lambda: self.newest.cycle >= cycle, limit_s)


@contextmanager
def watching(out: Path) -> Iterator[Watcher]:
    """Watch the clock of the run in a folder."""
    watcher = Watcher()
    met = read_endpoints(out)
    with open_session([], met.world[:1], realtime=True) as session:
        session.declare_subscriber(CLOCK.key(met.run), watcher.hear)
        yield watcher


def strike(started: Command, case: Case, out: Path) -> pb.Clock:
    """Wait for the moment, hit, and return the newest clock message by then.

    Raises TooLateError if the run is complete before its start is seen.
    """
    if case.moment == "start":
        first = "world" if case.victim == "command" else case.process
        if not started.has_children({first}):
            raise TooLateError
        # The moment is random on purpose, so there is no fact to wait for. What the test expects
        # holds at every moment of a start.
        let_pass(0.3 * case.at)
        if case.victim == "command":  # it may be gone at once, and its children have other parents
            started.wait_for_children(set())
        _hit(started, case)
        if case.victim != "command":
            started.wait_for_children(set())
        return pb.Clock()
    started.wait_for_children(case.others)
    with watching(out) as watcher:
        cycles = CYCLES[case.mode]
        most = 0.35 if case.mode == "realtime" else 0.8  # so a stall limit passes before the end
        share = (0.02 + most * case.at) if case.moment == "middle" else 1.0
        watcher.wait_for(max(1, round(share * cycles) - (case.moment == "last")), 60.0)
        _hit(started, case)
        return watcher.newest


def _hit(started: Command, case: Case) -> None:
    number = signal.Signals[f"SIG{case.blow.split()[0]}"]
    if case.victim == "command":
        started.send(number)
        return
    try:
        started.send_to_child(case.process, number)
    except ProcessLookupError:  # it has finished
        return


def go_on_later(started: Command, case: Case) -> None:
    """Let a stopped process go on, if the case says so."""
    if case.victim == "command":
        standstill_s = PAUSE_S if case.blow == "STOP 3 s" else STALL_LIMIT_S + 2.0
        let_pass(standstill_s)
        started.send(signal.SIGCONT)
    elif case.blow == "STOP 3 s":
        let_pass(PAUSE_S)
        try:
            started.send_to_child(case.process, signal.SIGCONT)
        except ProcessLookupError:
            return
