"""Does each task in its own process, several at a time, so that a failure affects no other task."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkProcess
from typing import Any, Generic, TypeVar

from zenvoy.fleet.requests import requests_held
from zenvoy.studies.worker import be_worker

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Done(Generic[T]):
    """A task that has ended; `failure` is a line about why it failed, or None."""

    task: T
    failure: str | None


def each_done(tasks: Sequence[T], do: Callable[[T], None], jobs: int) -> Iterator[Done[T]]:
    """Do each task in its own process, `jobs` at a time, and yield each when it ends.

    If the caller stops early or is interrupted, the processes are killed.
    """
    context = multiprocessing.get_context("fork")
    running: dict[int, tuple[ForkProcess, Connection, T]] = {}
    ahead = iter(tasks)
    left = len(tasks)
    try:
        while left:
            while len(running) < jobs and (task := next(ahead, None)) is not None:
                reader, writer = context.Pipe(duplex=False)
                child = context.Process(target=_work, args=(do, task, writer, os.getpid()))
                with requests_held():
                    child.start()
                writer.close()
                running[child.sentinel] = (child, reader, task)
            ended = wait(list(running))
            for sentinel in [one for one in running if one in ended]:
                child, reader, task = running.pop(sentinel)
                yield Done(task, _failure(child, reader))
                left -= 1
    finally:
        for child, reader, _ in running.values():
            child.kill()
            child.join()
            reader.close()


def _failure(child: ForkProcess, reader: Connection) -> str | None:
    child.join()
    with reader:
        try:
            return str(reader.recv()) if reader.poll() else died(child.exitcode)
        except EOFError:
            return died(child.exitcode)


def died(code: int | None) -> str | None:
    """Return how a process with an exit code died; None if it ended as it should."""
    if code == 0:
        return None
    if code is not None and code < 0:
        return f"its process was killed by {signal.Signals(-code).name}"
    return f"its process ended with exit code {code}"


def _work(do: Callable[[Any], None], task: Any, writer: Connection, parent: int) -> None:
    be_worker(parent)
    try:
        do(task)
    # Nothing is swallowed: the parent would otherwise only learn "exit code 1".
    except Exception as error:  # noqa: BLE001 - a law may raise anything; it is this run's result
        writer.send(in_one_line(error))


def in_one_line(error: BaseException) -> str:
    """Return the text of an error, or its kind, in one line."""
    return " ".join((str(error) or type(error).__name__).split())
