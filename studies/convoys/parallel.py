"""Does the same for many tasks in several processes, and returns the results in their order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from zenvoy.fleet.requests import requests_held
from zenvoy.studies.worker import worker_pool

T = TypeVar("T")
R = TypeVar("R")


def mapped(
    do: Callable[[T], R], tasks: Sequence[T], jobs: int, on_done: Callable[[int, R], None]
) -> list[R]:
    """Return the result of each task, `jobs` at a time; calls `on_done` with index and result.

    Raises what a task raises. If the caller is interrupted, the processes are killed.
    """
    with worker_pool(max(1, min(jobs, len(tasks)))) as pool:
        with requests_held():  # the pool forks its workers here
            futures = [pool.submit(do, task) for task in tasks]
        results = []
        for index, future in enumerate(futures):
            results.append(future.result())
            on_done(index, results[-1])
    return results
