"""The process beside a thread of a Dask worker: it forks a child for each parcel.

So if the user's own code hangs or dies, nothing else ends, as in a sweep on local cores.
"""

from __future__ import annotations

import sys
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from zenvoy.studies.sweeps.cluster.answer import Answer
from zenvoy.studies.sweeps.cluster.parcel import Parcel, parcel_in
from zenvoy.studies.sweeps.store import Store, new_store
from zenvoy.studies.sweeps.workers import each_done, in_one_line
from zenvoy.studies.worker import be_worker

_PREFIX: Final = "zenvoy-bench-"


def main(line: Connection, parent: int) -> None:
    """Answer parcels until the other end of the line is closed."""
    be_worker(parent)
    while True:
        try:
            packed = line.recv_bytes()
        except EOFError:
            return
        line.send_bytes(answer_to(parcel_in(packed)).packed())


def answer_to(parcel: Parcel) -> Answer:
    """Make the runs of a parcel in a separate process."""
    try:
        with TemporaryDirectory(prefix=_PREFIX) as folder:
            store = new_store(Path(folder))
            (done,) = each_done([parcel], partial(_make, store), 1)
            found = {key: store.files(key) for key in parcel.keys}
            runs = {key: files for key, files in found.items() if files is not None}
            return Answer(runs=runs, failure=done.failure)
    except OSError as error:  # no disk, or no process
        return Answer(failure=in_one_line(error))


def _make(store: Store, parcel: Parcel) -> None:
    parcel.make(store)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])), int(sys.argv[2]))
