"""Asks a run for its state from a process of its own.

A process that has opened a Zenoh session cannot fork processes with sessions any more.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence

from zenvoy.bus.doors import Doors
from zenvoy.bus.errors import NoAnswerError, SeveralRunsError
from zenvoy.bus.joining import RunState, ask


def ask_in_child(
    run: str | None, connect: Sequence[str], limit_s: float, doors: Doors | None
) -> RunState:
    """Return the state of a run as `ask` does; raises NoAnswerError, SeveralRunsError."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            os.close(reader)
            with os.fdopen(writer, "w", encoding="utf-8") as answer:
                json.dump(_asked(run, connect, limit_s, doors), answer)
            status = 0
        finally:
            os._exit(status)  # the child must never return into the frames of the parent
    os.close(writer)
    try:
        with os.fdopen(reader, encoding="utf-8") as answer:
            text = answer.read()
    finally:
        os.waitpid(pid, 0)
    if not text:
        raise NoAnswerError(f"the process that asks {', '.join(connect)} has died")
    answered = json.loads(text)
    if isinstance(answered, str):
        raise SeveralRunsError(answered)
    error, name, scenario, present, shared = answered
    if error:
        raise NoAnswerError(error)
    return RunState(name, scenario.encode(), frozenset(present), shared)


def _asked(
    run: str | None, connect: Sequence[str], limit_s: float, doors: Doors | None
) -> str | tuple[str, str, str, list[str], dict[str, list[int]]]:
    """Return which runs there are, if they are several; else an error, or the state of the run."""
    try:
        state = ask(run, connect, limit_s, doors)
    except SeveralRunsError as error:
        return str(error)
    except NoAnswerError as error:
        return str(error), "", "", [], {}
    return "", state.run, state.scenario.decode(), sorted(state.present), state.shared
