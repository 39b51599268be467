"""Starts a process table, watches it, and ends it: all of it, whatever happens."""

from __future__ import annotations

import gc
import os
import selectors
import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from zenvoy.bus.clock import wall_ns
from zenvoy.cli.spawn import Child, Program, requests_held, spawn

_PATIENCE_S: Final = 7.0  # for the log to be ended; its process gives itself 5 s
_TAIL_LINES: Final = 15


@dataclass(frozen=True, slots=True)
class Death:
    """A child that ended otherwise than it should."""

    name: str
    status: str
    tail: list[str] = field(default_factory=list)


class Supervisor:
    """Runs programs until the first of them, which leads, has ended.

    Use as a context: leaving it leaves no child behind.
    """

    def __init__(self, programs: Sequence[Program], logs: Path) -> None:
        self._programs = programs
        self._logs = logs
        self._children: dict[int, Child] = {}
        self._selector = selectors.DefaultSelector()

    def __enter__(self) -> Supervisor:
        gc.collect()
        gc.freeze()  # so that no child copies pages just to look for garbage
        try:
            for program in self._programs:
                with requests_held():
                    child = spawn(program, self._logs / f"{program.name}.log")
                    self._children[child.pidfd] = child
                    self._selector.register(child.pidfd, selectors.EVENT_READ)
        except BaseException:
            self.__exit__()
            raise
        finally:
            gc.unfreeze()
        return self

    def __exit__(self, *_: object) -> None:
        self._end_all()
        self._selector.close()

    def watch(
        self, pipe: int, on_data: Callable[[bytes], None], on_loss: Callable[[Death], None]
    ) -> Death | None:
        """Pass on what comes down the pipe until the leader ends.

        The first untimely death ends the watch and is returned, but for those of programs that are
        not essential: they go to `on_loss`.
        """
        self._selector.register(pipe, selectors.EVENT_READ)
        leader = next(iter(self._children))
        try:
            while True:
                ready = [key.fd for key, _ in self._selector.select()]
                if pipe in ready:
                    data = os.read(pipe, 65_536)
                    if data:
                        on_data(data)
                    else:
                        self._selector.unregister(pipe)
                ended = [(self._children[fd], self._reap(fd)) for fd in ready if fd != pipe]
                for child, status in ended:
                    if status == "exit status 0":
                        continue
                    death = Death(child.program.name, status, _tail(child.log))
                    if child.program.essential:
                        return death
                    on_loss(death)
                if leader not in self._children:
                    return None
        finally:
            if pipe in self._selector.get_map():
                self._selector.unregister(pipe)

    def _reap(self, pidfd: int) -> str:
        child = self._children.pop(pidfd)
        _, status = os.waitpid(child.pid, 0)
        self._selector.unregister(pidfd)
        os.close(pidfd)
        code = os.waitstatus_to_exitcode(status)
        return f"exit status {code}" if code >= 0 else f"killed by {signal.Signals(-code).name}"

    def _end_all(self) -> None:
        """Let the leader end the log while the others are still there, then end the others."""
        everyone = list(self._children.values())
        leaders = [child for child in everyone if child.program is self._programs[0]]
        for group in (leaders, everyone):
            self._ask(group, signal.SIGTERM)
            self._await(group, _PATIENCE_S)
        self._ask(everyone, signal.SIGKILL)
        self._await(everyone, _PATIENCE_S)

    def _ask(self, children: Sequence[Child], number: signal.Signals) -> None:
        for child in children:
            if child.pidfd in self._children:
                child.signal(number)
                child.signal(signal.SIGCONT)  # one that was frozen ends like the others

    def _await(self, children: Sequence[Child], limit_s: float) -> None:
        deadline_ns = wall_ns() + round(limit_s * 1e9)
        while any(child.pidfd in self._children for child in children):
            left_s = (deadline_ns - wall_ns()) * 1e-9
            if left_s <= 0:
                return
            for key, _ in self._selector.select(left_s):
                if key.fd in self._children:
                    self._reap(key.fd)


def _tail(log: Path) -> list[str]:
    try:
        return log.read_text(encoding="utf-8", errors="replace").splitlines()[-_TAIL_LINES:]
    except OSError:
        return []
