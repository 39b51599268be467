"""Asks a run for its state, or a router for a session, from a process of its own.

A process that has opened a Zenoh session cannot fork processes with sessions any more.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence

from zenvoy.bus.clock_bounds import Offset
from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import NoAnswerError, RouterError, SeveralRunsError
from zenvoy.bus.joining import RunState, ask
from zenvoy.bus.session import open_session


def ask_in_child(
    run: str | None,
    connect: Sequence[str],
    limit_s: float,
    doors: Doors | None,
    *,
    router: bool = False,
) -> RunState:
    """Return the state of a run as `ask` does; raises NoAnswerError, SeveralRunsError."""
    text = _in_child(lambda: _asked(run, connect, limit_s, doors, router=router))
    if not text:
        raise NoAnswerError(f"the process that asks {', '.join(connect)} has died")
    answered = json.loads(text)
    if isinstance(answered, str):
        raise SeveralRunsError(answered)
    error, name, scenario, present, shared, clock = answered
    if error:
        raise NoAnswerError(error)
    offset = None if clock is None else Offset(*clock)
    return RunState(name, scenario.encode(), frozenset(present), shared, offset)


def fault_of_router(router: str, doors: Doors | None) -> str:
    """Return why there is no session with a router, or "" if there is one."""

    def fault() -> str:
        try:
            open_session([], [router], doors=doors, router=True).close()
        except RouterError as error:
            return str(error)
        return ""

    text = _in_child(fault)
    return str(json.loads(text)) if text else f"the process that asks {router} has died"


def _in_child(work: Callable[[], object]) -> str:
    """Return the result of some work in a child process, as JSON; "" if it has died."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            os.close(reader)
            with os.fdopen(writer, "w", encoding="utf-8") as answer:
                json.dump(work(), answer)
            status = 0
        finally:
            os._exit(status)  # the child must never return into the frames of the parent
    os.close(writer)
    try:
        with os.fdopen(reader, encoding="utf-8") as answer:
            return answer.read()
    finally:
        os.waitpid(pid, 0)


def _asked(
    run: str | None, connect: Sequence[str], limit_s: float, doors: Doors | None, *, router: bool
) -> str | tuple[str, str, str, list[str], dict[str, list[int]], Offset | None]:
    """Return which runs there are, if they are several; else an error, or the state of the run."""
    try:
        state = ask(run, connect, limit_s, doors, router=router)
    except SeveralRunsError as error:
        return str(error)
    except NoAnswerError as error:
        return str(error), "", "", [], {}, None
    present = sorted(state.present)
    return "", state.run, state.scenario.decode(), present, state.shared, state.clock
