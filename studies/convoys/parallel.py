"""Does the same for many tasks in several processes, and returns the results in their order."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TypeVar

from zenvoy.fleet.requests import requests_held
from zenvoy.studies.worker import be_worker

T = TypeVar("T")
R = TypeVar("R")


def mapped(
    do: Callable[[T], R], tasks: Sequence[T], jobs: int, on_done: Callable[[int, R], None]
) -> list[R]:
    """Return the result of each task, `jobs` at a time; calls `on_done` with index and result.

    Raises what a task raises. If the caller is interrupted, the processes are killed.
    """
    pool = ProcessPoolExecutor(
        max(1, min(jobs, len(tasks))),
        multiprocessing.get_context("fork"),
        initializer=be_worker,
        initargs=(os.getpid(),),
    )
    try:
        with requests_held():  # the pool forks its workers here
            futures = [pool.submit(do, task) for task in tasks]
        results = []
        for index, future in enumerate(futures):
            results.append(future.result())
            on_done(index, results[-1])
    except BaseException:
        for child in multiprocessing.active_children():
            child.kill()
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()
    return results
