"""A Dask cluster of processes on the loopback interface, for tests."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.as_child import as_child
from tests.conftest import LIMIT_S, wait_until


@dataclass(frozen=True, slots=True)
class DaskCluster:
    """A scheduler and its workers, each a process."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: tuple[subprocess.Popen[bytes], ...]


@contextmanager
def dask_cluster(folder: Path, workers: int, allowed_failures: int = 3) -> Iterator[DaskCluster]:
    """Start a cluster on free ports, and kill it at the end.

    allowed_failures: how many workers may die that have a task before it counts as failed.
    """
    contact = folder / "scheduler.json"
    local = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(contact)]
    each = [*local, "--nthreads", "1", "--no-nanny", "--local-directory", str(folder)]
    started: list[subprocess.Popen[bytes]] = []
    try:
        started.append(_start(folder, "scheduler", [*local, "--port", "0"], allowed_failures))
        started += [_start(folder, "worker", each, allowed_failures) for _ in range(workers)]
        wait_until(lambda: _address(contact) is not None, "the Dask scheduler listens")
        scheduler, *others = started
        yield DaskCluster(_address(contact) or "", scheduler, tuple(others))
    finally:
        for process in started:
            process.kill()
            process.wait(LIMIT_S)


def _start(
    folder: Path, what: str, options: list[str], allowed_failures: int
) -> subprocess.Popen[bytes]:
    failures = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(allowed_failures)}
    dask = [sys.executable, "-m", "dask", what, "--dashboard-address", "127.0.0.1:0"]
    with (folder / f"{what}.log").open("ab") as log:
        return subprocess.Popen(
            as_child(*dask, *options, ignores_interrupts=True),
            cwd=folder,
            env={**os.environ, **failures},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )


def _address(contact: Path) -> str | None:
    try:
        return str(json.loads(contact.read_text())["address"])
    except (OSError, ValueError):
        return None
