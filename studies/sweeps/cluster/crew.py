"""The workers of a Dask cluster as a crew for sweeps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from typing import Final

from distributed import Client, Future, as_completed
from distributed.scheduler import KilledWorker

from zenvoy.scenarios import COMMAND_LINE, ScenarioError, Spelling
from zenvoy.studies.sweeps.cluster.answer import Answer, answer_in
from zenvoy.studies.sweeps.cluster.connecting import client_of, unlike_workers
from zenvoy.studies.sweeps.cluster.parcel import parcel_of
from zenvoy.studies.sweeps.cluster.versions import versions_here
from zenvoy.studies.sweeps.cluster.worker import UnlikeWorkerError, make
from zenvoy.studies.sweeps.errors import ClusterError
from zenvoy.studies.sweeps.plan import Plan, counted
from zenvoy.studies.sweeps.store import Store
from zenvoy.studies.sweeps.tasks import Task
from zenvoy.studies.sweeps.workers import Done, in_one_line

_FEWEST: Final = 8  # tasks in flight: a cluster without workers may start some for them


@contextmanager
def cluster_at(
    address: str, on_line: Callable[[str], None], spelling: Spelling = COMMAND_LINE
) -> Iterator[DaskCrew]:
    """Yield the cluster of the scheduler at an address; raises NoClusterError."""
    with client_of(address, spelling) as client:
        crew = DaskCrew(client, address)
        if not crew.threads:
            on_line(f"{address} has no workers yet; the runs wait for them")
        yield crew


class DaskCrew:
    """The workers of a cluster; see Crew.

    Two tasks for each thread of the workers are in flight. So a worker does not wait for its next
    task, and a large study fills neither the scheduler nor the memory of the caller.
    """

    def __init__(self, client: Client, address: str) -> None:
        self._client = client
        self._address = address
        self._needed = versions_here()

    @property
    def threads(self) -> int:
        """The number of threads of the present workers; raises ClusterError."""
        with self._scheduler():
            return sum(self._client.nthreads().values())

    @property
    def at_a_time(self) -> int:
        """See Crew; raises ClusterError."""
        return max(1, self.threads)

    @property
    def most_in_flight(self) -> int:
        """The number of tasks that the scheduler may hold; raises ClusterError."""
        return max(_FEWEST, 2 * self.threads)

    def each_done(self, tasks: Sequence[Task], plan: Plan, store: Store) -> Iterator[Done[Task]]:
        """See Crew. Raises ClusterError if the cluster is lost, and OSError from the store."""
        flying: dict[Future[bytes], Task] = {}
        landed = as_completed([], loop=self._client.loop)
        ahead = iter(tasks)
        try:
            while True:
                most = self.most_in_flight  # the scheduler is asked for its workers
                while len(flying) < most and (task := next(ahead, None)):
                    try:
                        packed = parcel_of(plan, task).packed()
                    except ScenarioError as error:
                        yield Done(task, in_one_line(error))
                        continue
                    with self._scheduler():
                        future = self._client.submit(make, packed, self._needed, pure=False)
                    flying[future] = task
                    landed.add(future)
                if not flying:
                    return
                future = next(landed)
                answer = self._answer(future)
                task = flying.pop(future)
                for key, files in answer.runs.items():
                    store.put(key, files)
                yield Done(task, answer.failure)
        finally:
            if flying:
                with suppress(Exception):  # the cluster is lost, and nothing is left to cancel
                    self._client.cancel(list(flying))

    def _answer(self, future: Future[bytes]) -> Answer:
        """Return the answer of a task that has ended; raises ClusterError."""
        with self._scheduler():
            error = future.exception()
            try:
                if error is None:
                    return answer_in(future.result())
            except KilledWorker as died:  # after the task, and before its answer was fetched
                error = died
            if isinstance(error, KilledWorker):
                return Answer(failure=killed(error))
            if isinstance(error, UnlikeWorkerError):
                raise ClusterError(str(error)) from error
            if unlike := unlike_workers(self._client):  # the worker could not even load the task
                raise ClusterError(unlike[0]) from error
        return Answer(failure=in_one_line(error))

    @contextmanager
    def _scheduler(self) -> Iterator[None]:
        """Tell what any request raises whose scheduler has gone. It may go at every request."""
        try:
            yield
        except (OSError, RuntimeError, CancelledError) as error:
            text = f"the Dask scheduler at {self._address} is lost"
            raise ClusterError(text) from error


def killed(error: KilledWorker) -> str:
    """Return in one line that every worker that had the task died."""
    times = counted(error.allowed_failures + 1, "time")
    return f"its Dask worker died {times}; the last one was {error.last_worker.address}"
