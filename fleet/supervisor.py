"""Starts the processes of a table, watches them, and ends all of them, whatever happens."""

from __future__ import annotations

import gc
import os
import selectors
import signal
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from zenvoy.bus.clock import wall_ns
from zenvoy.fleet.causes import FROZEN, Causes
from zenvoy.fleet.ends import DONE, FINISHED, STALLED, Death, LastWordsPipe
from zenvoy.fleet.frozen import Frozen
from zenvoy.fleet.requests import requests_held
from zenvoy.fleet.spawn import Child, Program, spawn

_END_LIMIT_S: Final = 7.0  # time for the world to finish the log; it allows itself 5 s
_CHECK_EVERY_S: Final = 0.5  # how often to look for frozen processes


class Supervisor:
    """Runs programs until the first of them, the leader, has ended; or all, if `all_lead`.

    A program that ends before the leader counts as dead unless its exit status is DONE. So does one
    that has been frozen for `stall_limit_s`. Use it as a context manager: no child outlives the
    context, and `completed` says whether the leader has done its work. `bad_ends` has the leaders
    that were asked to end and could not finish, such as a world that could not finish its log.
    """

    def __init__(
        self,
        programs: Sequence[Program],
        logs: Path,
        stall_limit_s: float,
        *,
        all_lead: bool = False,
    ) -> None:
        self._programs = programs
        self._leaders = list(programs if all_lead else programs[:1])
        self._working = [leader.name for leader in self._leaders]
        self._logs = logs
        self._children: dict[int, Child] = {}
        self._selector = selectors.DefaultSelector()
        self._words = LastWordsPipe()
        self._frozen = Frozen(stall_limit_s)
        self._causes = Causes(self._words, self._look_for_frozen)
        self._checked_ns = 0
        self._earlier_sigchld: Any = None  # the handler to restore
        self.completed = False
        self.bad_ends: list[Death] = []

    def __enter__(self) -> Supervisor:
        self._keep_exit_statuses()
        gc.collect()
        gc.freeze()  # so that the garbage collectors of the children copy no pages
        try:
            for program in self._programs:
                self._start(program)
        except BaseException:
            self.__exit__()
            raise
        finally:
            gc.unfreeze()
        return self

    def __exit__(self, *_: object) -> None:
        self._end_all()
        self._selector.close()
        self._words.close()
        if self._earlier_sigchld is not None:
            signal.signal(signal.SIGCHLD, self._earlier_sigchld)
            self._earlier_sigchld = None

    def _start(self, program: Program) -> None:
        """Start a program; one that follows another of its name has a log of its own."""
        log = self._logs / f"{program.name}.log"
        number = 1
        while log.exists():
            number += 1
            log = self._logs / f"{program.name}-{number}.log"
        with requests_held():
            child = spawn(program, log, self._words.send)
            self._children[child.pidfd] = child
            self._selector.register(child.pidfd, selectors.EVENT_READ)

    def _keep_exit_statuses(self) -> None:
        """Let the kernel keep the exit statuses of children until waitpid.

        This process may have been started with SIGCHLD ignored, and then waitpid would fail.
        """
        if threading.current_thread() is threading.main_thread():  # others cannot set handlers
            self._earlier_sigchld = signal.signal(signal.SIGCHLD, signal.SIG_DFL)

    def watch(
        self,
        pipe: int,
        on_data: Callable[[bytes], bool],
        on_loss: Callable[[Death], None],
        on_idle: Callable[[], None] = lambda: None,
    ) -> Death | None:
        """Pass data from the pipe to `on_data` until the leader ends.

        `on_data` returns whether the data say that the run has begun. `on_idle` is called when
        nothing has happened for half a second.
        The first death of an essential program ends the watch and is returned; other deaths go to
        `on_loss`. Until the run has begun, every program is essential, because it waits for all.
        """
        begun = False
        self._selector.register(pipe, selectors.EVENT_READ)
        try:
            while True:
                ready = [key.fd for key, _ in self._selector.select(_CHECK_EVERY_S)]
                if not ready:
                    on_idle()
                if pipe in ready:
                    data = os.read(pipe, 65_536)
                    if data:
                        begun = on_data(data) or begun
                    else:
                        self._selector.unregister(pipe)
                deaths = self._deaths([fd for fd in ready if fd != pipe])
                if self.completed:
                    return None
                for child, death in [*deaths, *self._stalled()]:
                    if child.program.essential or not begun:
                        return death
                    on_loss(death)
        finally:
            if pipe in self._selector.get_map():
                self._selector.unregister(pipe)

    def _deaths(self, pidfds: Sequence[int]) -> list[tuple[Child, Death]]:
        """Return the deaths among children that have ended; the stalled ones come last."""
        ended = [(self._children[fd], self._reap(fd)) for fd in pidfds]
        ended.sort(key=lambda one: one[1] == STALLED)
        deaths = []
        for child, code in ended:
            if self._is_planned(child.program, code):
                if child.program.successor is not None:
                    self._start(child.program.successor)
            elif code != DONE:
                deaths.append((child, self._causes.of_death(child, code)))
        return deaths

    def _is_planned(self, program: Program, code: int) -> bool:
        """Return whether a program has killed itself as the scenario wants it."""
        if not program.killed_with or code != -signal.SIGKILL:
            return False
        words = self._words.of(program.name)
        return words is not None and words.text == program.killed_with

    def _stalled(self) -> list[tuple[Child, Death]]:
        """Return the children that have now been frozen for the stall limit."""
        now_ns = wall_ns()
        if now_ns - self._checked_ns < _CHECK_EVERY_S * 1e9:
            return []
        self._checked_ns = now_ns
        self._frozen.look(self._children.values(), now_ns)
        return [(child, Death(child.program.name, FROZEN)) for child in self._frozen.due(now_ns)]

    def _look_for_frozen(self) -> Sequence[str]:
        """Return the names of the children that are frozen now."""
        self._frozen.look(self._children.values(), wall_ns())
        return self._frozen.names

    def _reap(self, pidfd: int) -> int:
        child = self._children.pop(pidfd)
        _, status = os.waitpid(child.pid, 0)
        self._selector.unregister(pidfd)
        os.close(pidfd)
        code = os.waitstatus_to_exitcode(status)
        is_over = code == DONE or not child.program.essential
        if is_over and child.program.name in self._working:
            self._working.remove(child.program.name)
        self.completed = not self._working
        return code

    def _end_all(self) -> None:
        """Let the leader finish the log while the others still run, then end the others."""
        everyone = list(self._children.values())
        leaders = [child for child in everyone if child.program in self._leaders]
        for group in (leaders, everyone):
            self._ask(group, signal.SIGTERM)
            self._await(group, _END_LIMIT_S)
        self._ask(everyone, signal.SIGKILL)
        self._await(everyone, _END_LIMIT_S)

    def _ask(self, children: Sequence[Child], number: signal.Signals) -> None:
        for child in children:
            if child.pidfd in self._children:
                child.signal(number)
                child.signal(signal.SIGCONT)  # a frozen child must wake up to end

    def _await(self, children: Sequence[Child], limit_s: float) -> None:
        deadline_ns = wall_ns() + round(limit_s * 1e9)
        while any(child.pidfd in self._children for child in children):
            left_s = (deadline_ns - wall_ns()) * 1e-9
            if left_s <= 0:
                return
            for key, _ in self._selector.select(left_s):
                if key.fd in self._children:
                    child = self._children[key.fd]
                    code = self._reap(key.fd)
                    if child.program in self._leaders and code not in FINISHED:
                        self.bad_ends.append(self._causes.of_bad_end(child, code))
