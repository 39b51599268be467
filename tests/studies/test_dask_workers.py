"""What a line says of a Dask worker that cannot take part, or that died."""

from __future__ import annotations

from distributed.scheduler import KilledWorker

from zenvoy.studies.sweeps.cluster.crew import killed
from zenvoy.studies.sweeps.cluster.versions import difference, versions_here


def test_a_worker_with_another_version_is_named() -> None:
    needed = versions_here()
    assert difference("tcp://w:1", needed, needed) is None
    told = difference("tcp://w:1", needed | {"numpy": "1.26.4", "zenvoy": None}, needed)
    assert told == (
        f"worker tcp://w:1: zenvoy is missing (needed: {needed['zenvoy']}), "
        f"numpy 1.26.4 (needed: {needed['numpy']})"
    )


def test_retries_that_are_used_up_are_counted() -> None:
    class State:
        address = "tcp://w:1"

    error = KilledWorker("task", State(), 3)  # type: ignore[arg-type]  # all that is read of it
    assert killed(error) == "its Dask worker died 4 times; the last one was tcp://w:1"
