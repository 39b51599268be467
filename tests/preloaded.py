"""Starts `zenvoy` commands as forks of a process that has imported Zenvoy, to save their imports.

A short command spends most of its time on imports. Each process of the tests starts one server
(`tests.command_server`), which imports Zenvoy once and forks for each command. The server tells the
exit code of a command, because only a parent can learn it.
"""

from __future__ import annotations

import atexit
import functools
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from tests.as_child import as_child

LARGEST: Final = 1 << 20
"""The largest request to the server, bytes: arguments and environment."""
_STYLING: Final = ("FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE", "LINES")


def plain_environment() -> dict[str, str]:
    """Return the environment of a terminal of 200 columns that asks for no colours."""
    kept = {name: value for name, value in os.environ.items() if name not in _STYLING}
    return {**kept, "COLUMNS": "200"}


class Forked:
    """A command that the server has forked, with what tests use of subprocess.Popen."""

    def __init__(self, pid: int, pidfd: int, answers: socket.socket) -> None:
        self.pid = pid
        self._pidfd = pidfd
        self._answers = answers
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return the exit code, or None while the command runs."""
        return self._end(0.0)

    def wait(self, limit_s: float) -> int:
        """Return the exit code; raises TimeoutExpired if the command still runs after limit_s."""
        code = self._end(limit_s)
        if code is None:
            raise subprocess.TimeoutExpired(f"process {self.pid}", limit_s)
        return code

    def send_signal(self, number: signal.Signals) -> None:
        """Send a signal to the command, never to another process that has got its id."""
        if self.poll() is None:
            signal.pidfd_send_signal(self._pidfd, number)

    def _end(self, limit_s: float) -> int | None:
        if self._code is None:
            if not select.select([self._answers], [], [], limit_s)[0]:
                return None
            answer = self._answers.recv(64)
            if not answer:
                raise RuntimeError("the server of preloaded commands has ended")
            self._code = int(answer)
            self._answers.close()
            os.close(self._pidfd)
        return self._code


def reads_the_same(env: Mapping[str, str]) -> bool:
    """Return whether an interpreter that starts with `env` starts as that of the server did."""
    return _read_at_start(env) == _READ_AT_START


def _read_at_start(env: Mapping[str, str]) -> dict[str, str]:
    prefixes = ("PYTHON", "LC_", "LANG", "LD_")
    return {name: value for name, value in env.items() if name.startswith(prefixes)}


_READ_AT_START: Final = _read_at_start(os.environ)


def fork(argv: Sequence[str], cwd: Path, env: Mapping[str, str], out: int, err: int) -> Forked:
    """Start a command with these arguments and streams, in a session of its own.

    It inherits the network namespace of this thread.
    """
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    request = {"argv": argv, "cwd": str(cwd), "env": dict(env)}
    with theirs, open(os.devnull, "rb") as nothing, open("/proc/thread-self/ns/net") as network:
        fds = [nothing.fileno(), out, err, network.fileno(), theirs.fileno()]
        socket.send_fds(_server(), [json.dumps(request).encode()], fds)
    message, (pidfd,), _, _ = socket.recv_fds(ours, 64, 1)
    return Forked(int(message), pidfd, ours)


@functools.cache
def _server() -> socket.socket:
    """Start the server of this process, which dies with it, and return the way to ask it."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, LARGEST)
    with theirs:
        server = subprocess.Popen(
            as_child(sys.executable, "-m", "tests.command_server", str(theirs.fileno())),
            cwd=Path(__file__).parents[1],
            env=plain_environment(),  # which Zenvoy's modules may read when they are imported
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
    atexit.register(_end, ours, server)
    return ours


def _end(requests: socket.socket, server: subprocess.Popen[bytes]) -> None:
    requests.close()
    server.wait()
