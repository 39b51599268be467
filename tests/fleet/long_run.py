"""A long run on processes, for tests that end it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.conftest import Command, command
from tests.streamed_log import Log
from zenvoy.bus import messages_pb2 as pb

# Far longer than any test waits.
LONG = """
duration_s: 100000
fleet: {size: 3}
channel: {loss: {p: 0.1}}
"""
NAMES = {"world", "channel", "vehicle-01", "vehicle-02", "vehicle-03"}


@contextmanager
def running(folder: Path, *arguments: str, scenario: str = LONG) -> Iterator[Command]:
    """Start a long run on Zenoh, and wait until it has cycles. Its log is out/run.mcap."""
    (folder / "long.yaml").write_text(scenario)
    with command(folder, "run", "long.yaml", "--out", "out", *arguments) as started:
        started.wait_for_children(NAMES)
        started.wait_for_cycles(folder / "out" / "run.mcap")
        yield started


def events(log: Log) -> list[tuple[int, str]]:
    """Return kinds and texts of the events in the order of the log."""
    found = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [(event.kind, event.text) for event in found]


def assert_stopped(log: Log) -> None:
    """Check that the log is complete, and has the time at which the run was stopped."""
    assert log.whole
    assert log.result["end"] == "stopped"
    assert events(log)[-1] == (pb.EVENT_STOPPED, "asked to end")
    assert int(log.result["cycles"]) == len(log.of("/fleet/truth")) - 1
