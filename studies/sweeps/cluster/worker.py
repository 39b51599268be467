"""The function that a worker of Dask calls."""

from __future__ import annotations

import threading
from typing import Final

from distributed import get_worker

from zenvoy.studies.sweeps.cluster.bench import Bench
from zenvoy.studies.sweeps.cluster.versions import Versions, difference, versions_here

_own: Final = threading.local()


class UnlikeWorkerError(Exception):
    """The worker has other versions than the caller; the text says which in one line."""


def make(packed: bytes, needed: Versions) -> bytes:
    """Return the packed answer to a packed parcel; raises UnlikeWorkerError before any run."""
    if unlike := difference(get_worker().address, versions_here(), needed):
        raise UnlikeWorkerError(unlike)
    bench: Bench | None = getattr(_own, "bench", None)
    if bench is None or not bench.works:
        bench = _own.bench = Bench()
    return bench.made(packed)
