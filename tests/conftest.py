"""Helpers run the `zenvoy` command as its users do, and wait for what it does.

Every wait is for a fact, never for a time. After LIMIT_S it fails and names the fact.
"""

from __future__ import annotations

import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import psutil
import pytest
from hypothesis import settings

from tests.as_child import as_child
from tests.preloaded import Forked, fork, plain_environment, reads_the_same
from tests.streamed_log import Log, read_log

# Other programs may keep every core busy, so the time of an example has no meaning.
settings.register_profile("busy", deadline=None)
settings.load_profile("busy")

# A shell that puts the tests into the background has them ignore Ctrl-C, and nohup SIGHUP. Zenvoy
# respects that, so its tests start as in a terminal.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)

LIMIT_S: Final = 180.0
"""How long tests wait before they call it a hang, s: longer than a busy machine needs."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that the tests of a module share."""
    return tmp_path_factory.mktemp("module")


def wait_until(fact: Callable[[], bool], what: str, limit_s: float = LIMIT_S) -> None:
    """Return when `fact` holds. Fail with `what` if it does not hold within `limit_s`."""
    deadline = time.monotonic() + limit_s
    while not fact():
        if time.monotonic() > deadline:
            pytest.fail(f"after {limit_s:g} s still not: {what}")
        time.sleep(0.01)  # between looks, which decide: no call waits for any kind of fact


@dataclass(frozen=True, slots=True)
class Outcome:
    """The exit code of a command, and its output."""

    code: int
    out: str
    err: str


class Command:
    """A running `zenvoy` command, with its own process group, in the folder `cwd`.

    It is a fork of a process that has imported Zenvoy. It runs from its start, with an interpreter
    of its own, if a test looks at that, or has settings that count from there: `env`, `stdout`,
    `limit` and `inside`.
    """

    def __init__(
        self,
        cwd: Path,
        *arguments: str,
        env: Mapping[str, str] | None = None,
        stdout: int | None = None,
        limit: tuple[int, int] | None = None,
        inside: Sequence[str] = (),
        from_start: bool = False,
    ) -> None:
        # Not in `cwd`: a command that starts there meanwhile would write to the same files.
        printed = tempfile.mkdtemp(prefix="zt-printed-")
        weakref.finalize(self, shutil.rmtree, printed)
        self._out, self._err = Path(printed, "out"), Path(printed, "err")
        self.sockets = tempfile.TemporaryDirectory(prefix="zt-")  # paths of sockets are short
        self._pidfds: dict[str, int] = {}
        environment = {**plain_environment(), "TMPDIR": self.sockets.name, **(env or {})}
        self._process: subprocess.Popen[bytes] | Forked
        with self._out.open("wb") as out, self._err.open("wb") as err:
            has_settings = env or stdout is not None or limit or inside
            if from_start or has_settings or not reads_the_same(environment):
                self._process = subprocess.Popen(
                    as_child(*inside, *_zenvoy(), *arguments, limit=limit),
                    cwd=cwd,
                    env=environment,
                    stdin=subprocess.DEVNULL,
                    stdout=out if stdout is None else stdout,
                    stderr=err,
                    start_new_session=True,
                )
            else:
                command = [*_zenvoy(), *arguments]
                self._process = fork(command, cwd, environment, out.fileno(), err.fileno())

    @property
    def pid(self) -> int:
        """Return the id of the command, which is also that of its process group."""
        return self._process.pid

    @property
    def out(self) -> str:
        """Return the output of the command so far."""
        return self._out.read_text(encoding="utf-8")

    def children(self) -> dict[str, list[str]]:
        """Return the titles of its child processes by name, split as in /proc/<pid>/cmdline."""
        titles: dict[str, list[str]] = {}
        self._pids: dict[str, int] = {}
        for child in psutil.Process(self.pid).children():
            title = _title(child.pid)
            if title[:1] == ["zenvoy"] and len(title) > 1:
                titles[title[1]] = title
                self._pids[title[1]] = child.pid
        return titles

    def pid_of(self, name: str) -> int | None:
        """Return the process id of a child at the last call of `children`; None if it was gone."""
        return self._pids.get(name)

    def wait_for_children(self, names: set[str]) -> dict[str, int]:
        """Return process ids by name once all of `names` exist, and watch them from then on."""
        assert self.has_children(names), self.wait()
        return self._pids

    def has_children(self, names: set[str]) -> bool:
        """Return whether all of `names` come to exist before the command ends; watch them."""
        wait_until(
            lambda: self.has_ended() or names <= self.children().keys(),
            f"the processes {', '.join(sorted(names))} are there",
        )
        if self.has_ended():
            return False
        for name, pid in self._pids.items():
            self._pidfds.setdefault(name, os.pidfd_open(pid))
        return True

    def wait_for_cycles(self, log: Path) -> None:
        """Return once the log on disk has reached a cycle."""

        def has_cycles() -> bool:
            big_enough = log.exists() and log.stat().st_size > 20_000
            return self.has_ended() or (big_enough and bool(read_log(log).of("/fleet/truth")))

        wait_until(has_cycles, f"{log} has reached a cycle")
        assert not self.has_ended(), self.wait()

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the command alone."""
        self._process.send_signal(number)

    def send_to_group(self, number: signal.Signals) -> None:
        """Send a signal to the command and its children, as a terminal does."""
        os.killpg(self.pid, number)

    def send_to_child(self, name: str, number: signal.Signals) -> None:
        """Send a signal to a watched child, and never to a process that reuses its id."""
        signal.pidfd_send_signal(self._pidfds[name], number)

    def has_ended(self) -> bool:
        """Return whether the command has ended."""
        return self._process.poll() is not None

    def wait(self, limit_s: float = LIMIT_S) -> Outcome:
        """Wait until the command has ended, and return its outcome."""
        try:
            code = self._process.wait(limit_s)
        except subprocess.TimeoutExpired:
            pytest.fail(f"the command has not ended within {limit_s:g} s; it printed: {self.out}")
        return Outcome(code, self.out, self._err.read_text(encoding="utf-8"))

    def left(self, limit_s: float = LIMIT_S) -> list[str]:
        """Return the watched children that do not end within `limit_s` (0: that still run)."""
        deadline = time.monotonic() + limit_s
        return [
            name
            for name, pidfd in self._pidfds.items()
            if not select.select([pidfd], [], [], max(0.0, deadline - time.monotonic()))[0]
        ]

    def close(self) -> None:
        """End all remaining processes of the command."""
        if self._process.poll() is None or self.left(0.0):
            self.send_to_group(signal.SIGKILL)
        self._process.wait(LIMIT_S)
        self.left()
        for pidfd in self._pidfds.values():
            os.close(pidfd)
        self.sockets.cleanup()


def _zenvoy() -> list[str]:
    script = Path(sys.executable).with_name("zenvoy")
    return [str(script)] if script.exists() else [sys.executable, "-m", "zenvoy.cli"]


def _title(pid: int) -> list[str]:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode().split()
    except OSError:  # it has ended meanwhile
        return []


@contextmanager
def command(cwd: Path, *arguments: str, **options: Any) -> Iterator[Command]:
    """Start a command that ends with the context, whatever happens in it."""
    started = Command(cwd, *arguments, **options)
    try:
        yield started
    finally:
        started.close()


def zenvoy(cwd: Path, *arguments: str, **options: Any) -> Outcome:
    """Run a command to its end."""
    with command(cwd, *arguments, **options) as started:
        return started.wait()


def run(folder: Path, scenario: str, *arguments: str) -> Log:
    """Run a scenario, given as YAML, in a new folder, and return the log of the run.

    The run must succeed, but may have notes on its scenario.
    """
    folder.mkdir()
    (folder / "s.yaml").write_text(scenario)
    outcome = zenvoy(folder, "run", "s.yaml", "--out", "out", *arguments)
    errors = [line for line in outcome.err.splitlines() if not line.startswith("note: ")]
    assert (outcome.code, errors) == (0, []), outcome
    return read_log(folder / "out" / "run.mcap")
