"""Worker processes of a study: they die with the study, and leave the terminal to it."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

from zenvoy.fleet.requests import REQUESTS_TO_END
from zenvoy.fleet.spawn import die_with


def be_worker(parent: int) -> None:
    """Make this forked process a worker. Fork it in `requests_held`: this unblocks the requests.

    Signals from the terminal are for the parent, which kills its workers.
    """
    die_with(parent, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, REQUESTS_TO_END)


@contextmanager
def worker_pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Provide a pool of forked workers; submit tasks in `requests_held`, which is where it forks.

    If the context ends with an exception, the workers are killed.
    """
    pool = ProcessPoolExecutor(
        jobs, multiprocessing.get_context("fork"), initializer=be_worker, initargs=(os.getpid(),)
    )
    try:
        yield pool
    except BaseException:
        for child in multiprocessing.active_children():
            child.kill()
        # Wait: Python's own end, and that of the pool's thread, would close one pipe twice.
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()
