"""Commands of this machine as several machines, which connect over TLS."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from tests.conftest import LIMIT_S, Command, command, wait_until, zenvoy
from tests.fleet.joining import free_ports, meeting

TIMED: Final = """
duration_s: 4
clock: realtime
fleet: {size: 8}
control: {v2v_wait_ms: 50, system_delay_ms: 60}
max_clock_error_ms: 500
"""
"""A run in real time of eight vehicles."""


@contextmanager
def serving(folder: Path, scenario: str, *options: str) -> Iterator[tuple[Command, list[str]]]:
    """Serve a scenario with locked doors; yield the command, and options by which to join it."""
    (folder / "s.yaml").write_text(scenario)
    groups = ("--group", "1-4", "--group", "5-8")
    assert zenvoy(folder, "certs", "keys", "--vehicles", "8", *groups).code == 0
    doors = [f"tls/127.0.0.1:{port}" for port in free_ports()]
    locked = ("--listen", doors[0], "--certs", "keys", "--out", "out")
    with command(folder, "serve", "s.yaml", *locked, *options) as started:
        wait_until((folder / "out" / "connect.json").exists, "it says where to connect to")
        there = ["--run", meeting(folder)["run"], "--connect", doors[0], "--connect", doors[1]]
        patient = ["--timeout-s", f"{LIMIT_S:g}"]
        yield started, [*there, "--certs", str(folder / "keys"), *patient]


@contextmanager
def host(
    folder: Path, name: str, vehicles: str, *options: str, inside: Sequence[str] = ()
) -> Iterator[Command]:
    """Join a run with some vehicles, as a machine of this name; inside: a command that runs it."""
    (folder / name).mkdir()
    share = ("--vehicles", vehicles, "--host", name, "--out", "out")
    with command(folder / name, "join", *share, *options, inside=inside) as started:
        yield started
