"""A process beside a thread of a Dask worker, which makes the runs of one parcel after the other.

A worker has many threads, so it cannot fork safely: a lock that another thread holds would stay
locked in the child. The process beside it has one thread. It also keeps Zenvoy's imports, which
take seconds, away from the thread of the worker that talks to the scheduler.
"""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing import Pipe
from typing import Final

from zenvoy.studies.sweeps.cluster.answer import Answer
from zenvoy.studies.sweeps.workers import died

_MODULE: Final = "zenvoy.studies.sweeps.cluster.bench_process"


class Bench:
    """The process as its thread sees it. It ends when the thread ends, or the whole worker."""

    def __init__(self) -> None:
        self._line, far_end = Pipe()
        with far_end:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", _MODULE, str(far_end.fileno()), str(os.getpid())],
                stdin=subprocess.DEVNULL,
                pass_fds=[far_end.fileno()],
            )

    @property
    def works(self) -> bool:
        """Whether the process is running."""
        return self._process.poll() is None

    def made(self, packed: bytes) -> bytes:
        """Return the packed answer to a packed parcel."""
        try:
            self._line.send_bytes(packed)
            return self._line.recv_bytes()
        except (EOFError, OSError):
            code = self._process.wait()
            return Answer(failure=died(code) or "its process ended too early").packed()
