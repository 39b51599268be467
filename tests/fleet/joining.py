"""Runs in real time that vehicles of other programs join, and what their logs say."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from tests.conftest import Command, command
from tests.streamed_log import Log, read_log
from zenvoy.bus import messages_pb2 as pb

_RESERVED: Final[list[socket.socket]] = []  # open as long as this process lives
# Far longer than any test waits.
LONG = """
duration_s: 100000
fleet: {size: 3}
control: {v2v_wait_ms: 50, system_delay_ms: 60, beacon_age_limit_ms: 500}
"""
STEPPED = """
duration_s: 20
fleet: {size: 4}
channel: {loss: {p: 0.1}}
"""


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[Command]:
    """Start a long run in real time, and wait until it has cycles. Its folder is out."""
    (folder / "long.yaml").write_text(LONG)
    options = ("--realtime", "--out", "out", *arguments)
    with command(folder, "run", "long.yaml", *options) as started:
        started.wait_for_children({"world", "channel"})
        started.wait_for_cycles(folder / "out" / "run.mcap")
        yield started


@contextmanager
def joining(folder: Path, *arguments: str) -> Iterator[Command]:
    """Start `zenvoy vehicle` in its own folder beside that of the run."""
    own = folder / "-".join(["vehicle", *arguments[1:2]])
    own.mkdir()
    with command(own, "vehicle", *arguments) as started:
        yield started


def events(log: Log) -> list[tuple[int, int, str]]:
    """Return kind, vehicle and text of the events of a run so far."""
    found = [pb.Event.FromString(message.data) for message in log.of("/events")]
    return [(event.kind, event.vehicle, event.text) for event in found]


def has_happened(folder: Path, *wanted: tuple[int, int, str]) -> bool:
    """Return whether the log of the run has all these events, in this order."""
    found = iter(events(read_log(folder / "out" / "run.mcap")))
    return all(event in found for event in wanted)


def meeting(folder: Path) -> dict[str, Any]:
    """Return the content of the run's connect.json."""
    endpoints: dict[str, Any] = json.loads((folder / "out" / "connect.json").read_text())
    return endpoints


def commanded(folder: Path, vehicle: int) -> list[pb.RealTime]:
    """Return the rows of the cycles in which the vehicle has sent a command."""
    log = read_log(folder / "out" / "run.mcap")
    rows = [pb.RealTime.FromString(message.data) for message in log.of("/realtime")]
    return [row for row in rows if row.commanded_ns[vehicle - 1] >= 0]


def free_ports() -> tuple[int, int]:
    """Return two successive ports on which nobody listens, and which no other test gets.

    A socket of an abstract name, which ends with this process, reserves them among all processes of
    this machine: between this call and the run that listens, another test could take them.
    """
    for port in range(7447, 9447, 2):
        mine = socket.socket(socket.AF_UNIX)
        try:
            mine.bind(f"\0zenvoy-test-port-{port}")
            with socket.socket() as first, socket.socket() as second:
                first.bind(("127.0.0.1", port))
                second.bind(("127.0.0.1", port + 1))
        except OSError:
            mine.close()
            continue
        _RESERVED.append(mine)
        return port, port + 1
    raise AssertionError("no free ports")
