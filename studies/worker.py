"""A worker process of a study: it dies with the study, and leaves the terminal to it."""

from __future__ import annotations

import signal

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
