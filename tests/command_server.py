"""A process that has imported Zenvoy, and forks a `zenvoy` command for each request.

The fork gets a session, folder, environment and streams of its own, runs the entry point of
`zenvoy`, and ends as an interpreter ends. It answers with its pid and a pidfd, and its parent, the
server, later with its exit code.
"""

from __future__ import annotations

import ctypes
import gc
import json
import os
import select
import signal
import socket
import sys
import tempfile
from contextlib import suppress
from types import ModuleType
from typing import Any, Final

from setproctitle import setproctitle

from tests.preloaded import LARGEST
from zenvoy.cli import analyze, app, entry, execute

IMPORTED: Final[tuple[ModuleType, ...]] = (analyze, app, entry, execute)
"""What each fork has from its start, with all that these import."""
_FDS: Final = 5
"""A request brings three standard streams, a network namespace, and the socket for its answers."""
_CLONE_NEWNET: Final = 0x4000_0000
_PR_SET_PDEATHSIG: Final = 1


def main(number: str) -> None:
    """Serve the requests from a socket until the tests end; run the command in each fork."""
    setproctitle("command server")  # finds the place of titles, which goes with the environment
    gc.freeze()  # forks share what is imported, and a collection would copy it
    if _serve(socket.socket(fileno=int(number))):
        entry.main()


def _serve(requests: socket.socket) -> bool:
    """Return True in a fork, and False when the tests have ended."""
    woken, wake = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.set_wakeup_fd(wake)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    running: dict[int, socket.socket] = {}
    while True:
        ready, _, _ = select.select([requests.fileno(), woken], [], [])
        if woken in ready:
            os.read(woken, 4096)
            _report_ends(running)
        if requests.fileno() not in ready:
            continue
        data, fds, _, _ = socket.recv_fds(requests, LARGEST, _FDS)
        if not data:
            return False
        server = os.getpid()
        pid = os.fork()
        answers = socket.socket(fileno=fds.pop())
        if pid == 0:
            for others in running.values():
                others.close()
            requests.close()
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            os.close(woken)
            os.close(wake)
            _become(json.loads(data), fds, server)
            _present(answers)
            return True
        running[pid] = answers
        for fd in fds:
            os.close(fd)


def _report_ends(running: dict[int, socket.socket]) -> None:
    for pid in list(running):
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            with running.pop(pid) as answers, suppress(BrokenPipeError):  # nobody waits for it
                answers.send(str(os.waitstatus_to_exitcode(status)).encode())


def _become(request: dict[str, Any], fds: list[int], server: int) -> None:
    """Take over what belongs to a command: its session, folder, environment, network, streams."""
    *streams, network = fds
    os.setsid()
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != server:  # it has ended before the call above
        os.kill(os.getpid(), signal.SIGKILL)
    here = os.stat("/proc/self/ns/net")
    if not os.path.samestat(os.fstat(network), here) and libc.setns(network, _CLONE_NEWNET):
        raise OSError(ctypes.get_errno(), "setns")
    os.close(network)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    tempfile.tempdir = None
    sys.argv = request["argv"]
    sys.modules["__main__"] = ModuleType("__main__")  # where click looks up how it was called
    setproctitle(" ".join(sys.argv))


def _present(answers: socket.socket) -> None:
    """Tell the test which process has become its command."""
    pidfd = os.pidfd_open(os.getpid())
    with answers:
        socket.send_fds(answers, [str(os.getpid()).encode()], [pidfd])
    os.close(pidfd)


if __name__ == "__main__":
    main(sys.argv[1])
